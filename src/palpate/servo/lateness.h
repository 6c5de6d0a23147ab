/// \file
/// Accumulated lateness of a loop's ticks.
#pragma once

#include <algorithm>

namespace palpate {

/// Time by which ticks are late, in sum. A tick is late if it comes more than kOnTime periods after the one
/// before; the sum decays by kForgiven of the time that passes. See SafetyLimits::late_max.
class Lateness {
 public:
  /// Counts one tick. \param most upper bound of the sum. Unit: [s]. \param passed time since the last tick.
  /// Unit: [s]. \param period of the loop. Unit: [s]. \returns true if the sum was greater: the loop is too
  /// late.
  bool exceeds(double most, double passed, double period) {
    sum_ = std::max(0.0, sum_ - kForgiven * passed) + std::max(0.0, passed - kOnTime * period);
    if (sum_ <= most) return false;
    sum_ = most;
    return true;
  }

  static constexpr double kOnTime = 2.0;  ///< Unit: [periods].
  static constexpr double kForgiven = 0.1;

 private:
  double sum_ = 0.0;  ///< Unit: [s].
};

}  // namespace palpate
