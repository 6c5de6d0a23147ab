/// \file
/// Wake-up event between threads.
#pragma once

namespace palpate {

/// A wake-up event (Linux eventfd) that a thread can wait for and an event loop can watch. set() neither
/// blocks nor allocates.
class Wake {
 public:
  /// \throws Error if the eventfd cannot be created.
  Wake();
  ~Wake();
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  /// Any thread.
  void set();
  /// Waits for set(), at most `seconds`, and clears the event; an earlier set() counts.
  void wait(double seconds);
  /// Clears the event.
  void clear();
  /// Returns the file descriptor, readable while the event is set.
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace palpate
