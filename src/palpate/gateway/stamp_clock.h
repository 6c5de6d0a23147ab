/// \file
/// Clock offset estimation for stamped messages of a publisher.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include <palpate/gateway/client_clock.h>

namespace palpate {

/// Estimates the offset between the clock of message stamps and the loop's clock: by echoes (ClientClock) if
/// the publisher answers them, else by the recent minimum of `arrival - stamp`, which is the clock offset
/// plus the shortest delay. That delay is then unknown and assumed to be `one_way`.
///
/// An age includes the latency of the answer, so that it is the age of a pose when the motors respond to it,
/// as the passivity margin requires. Used by one thread; does not allocate.
class StampClock {
 public:
  /// \param one_way shortest delay from the publisher to this host. Unit: [s].
  explicit StampClock(double one_way) : one_way_(one_way) { reset(); }

  /// Returns the age of a message with stamp `stamp` that arrived at `now`. Unit: [s]. \returns nothing for a
  /// stamp that is more than kFuture ahead of what the clock offset allows.
  std::optional<double> age(double stamp, double now);

  /// Returns the echo clock, for ClientClock::ask() and answer().
  ClientClock& echoes() { return echoes_; }
  /// Forgets the offset, after the publisher's clock was set.
  void reset();

  /// Maximum lead of a stamp. Unit: [s].
  static constexpr double kFuture = 0.05;
  /// Memory of the offset minimum: clocks 20 ppm apart drift by 0.1 ms in that time. Unit: [s].
  static constexpr int kSeconds = 5;

 private:
  double least_offset() const;

  double one_way_;
  ClientClock echoes_;
  /// Minimum of `arrival - stamp` in each of the last seconds; infinite without a message. Unit: [s].
  std::array<double, kSeconds> least_{};
  std::int64_t second_ = 0;  ///< number of the newest of these seconds
};

}  // namespace palpate
