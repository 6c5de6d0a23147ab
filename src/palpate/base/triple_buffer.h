/// \file
/// Triple buffer: passes the newest value from one thread to another.
#pragma once

#include <array>
#include <atomic>

namespace palpate {

/// Wait-free triple buffer with three slots of T: one that the writer fills, one that the reader reads, and
/// one between them that is exchanged. Neither thread ever waits; the reader sees the newest published value,
/// and values it did not read in time are lost.
///
/// One writer thread, one reader thread. T is never copied.
template <class T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  /// Constructs each slot as T(argument).
  template <class Argument>
  explicit TripleBuffer(const Argument& argument) : places_{T(argument), T(argument), T(argument)} {}

  /// \name Writer thread
  /// @{
  T& back() { return places_[back_]; }
  /// Publishes back(), which then refers to another slot that holds an old value.
  void publish() { back_ = between_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kPlace; }
  /// @}

  /// \name Reader thread
  /// @{
  /// Fetches the newest value into front(). \returns true if it is a new one.
  bool update() {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0U) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kPlace;
    return true;
  }
  T& front() { return places_[front_]; }
  const T& front() const { return places_[front_]; }
  /// @}

 private:
  static constexpr unsigned kPlace = 3, kFresh = 4;

  std::array<T, 3> places_{};
  unsigned back_ = 0, front_ = 1;
  std::atomic<unsigned> between_ = 2;
};

}  // namespace palpate
