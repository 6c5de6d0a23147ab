/// \file
/// The newest value from one thread to another.
#pragma once

#include <array>
#include <atomic>

namespace palpate {

/// Three places for a T: one that the writer fills, one that the reader looks at, and one between them that
/// changes hands. Neither ever waits, for the other or for anything else; the reader sees the newest that was
/// published, and values that it was too slow for are gone.
///
/// One thread writes, one reads. T is never copied here.
template <class T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  /// Each of the three is T(argument).
  template <class Argument>
  explicit TripleBuffer(const Argument& argument) : places_{T(argument), T(argument), T(argument)} {}

  /// \name The writer's
  /// @{
  T& back() { return places_[back_]; }
  /// Hands over back(), which is then another place, with an old value in it.
  void publish() { back_ = between_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kPlace; }
  /// @}

  /// \name The reader's
  /// @{
  /// True if front() is another value than before.
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
