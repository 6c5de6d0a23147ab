/// \file
/// What one thread wakes another with.
#pragma once

namespace palpate {

/// A counter of the kernel (eventfd) that a thread can wait for, and an event loop watch. set() neither
/// blocks nor takes memory.
class Wake {
 public:
  /// \throws Error if the system has no more of them.
  Wake();
  ~Wake();
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  /// Any thread.
  void set();
  /// Waits for set(), for `seconds` at most; what was set before counts, and is taken back.
  void wait(double seconds);
  /// Takes back what was set.
  void clear();
  /// Readable while it is set.
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace palpate
