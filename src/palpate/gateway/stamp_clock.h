/// \file
/// What the stamps of a publisher say on this machine's clock.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include <palpate/gateway/client_clock.h>

namespace palpate {

/// Compares the clock that messages are stamped with to the loop's: by echoes (ClientClock) where the
/// publisher answers them, else by the least of what `arrival - stamp` was lately, which is the clocks'
/// offset and the shortest delay there is. That delay is not known then; `one_way` is assumed for it.
///
/// An age counts the way of the answer back as well, so that it is how old a pose is when the motors answer
/// it: what the passivity margin has to know. Used by one thread; takes nothing from the heap.
class StampClock {
 public:
  /// \param one_way shortest delay from publisher to here. Unit: [s].
  explicit StampClock(double one_way) : one_way_(one_way) { reset(); }

  /// Age of what is stamped `stamp` and has come at `now`. Unit: [s]. \returns nothing for a stamp that is
  /// more than kFuture ahead of what the clocks' offset allows.
  std::optional<double> age(double stamp, double now);

  /// For echoes: ClientClock::ask() and answer().
  ClientClock& echoes() { return echoes_; }
  /// The clock that stamps was set: nothing is known of it any longer.
  void reset();

  /// By how much a stamp may lead. Unit: [s].
  static constexpr double kFuture = 0.05;
  /// How long an offset is remembered: clocks 20 ppm apart differ by 0.1 ms then. Unit: [s].
  static constexpr int kSeconds = 5;

 private:
  double least_offset() const;

  double one_way_;
  ClientClock echoes_;
  /// Least `arrival - stamp` of each of the last seconds; infinite where nothing came. Unit: [s].
  std::array<double, kSeconds> least_{};
  std::int64_t second_ = 0;  ///< of the newest of them
};

}  // namespace palpate
