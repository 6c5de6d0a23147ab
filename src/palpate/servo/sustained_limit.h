/// \file
/// What motors can hold without getting too hot.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

/// Brings a force (or torque) down from the peak to what the motors hold for ever, before they are too hot.
/// The heat of a motor goes with the square of its current, so of its force; with F what was sent, F_s the
/// sustained and F_p the peak limit,
///
///     h' = (F^2 / F_s^2 - h) / kTime        h in [0, 1]: the mean of F^2 over kTime, of what it may be
///     |F| <= F_s + (F_p - F_s) min(1, 2 (1 - h))
///
/// so that h is never above 1: once it is there, F is F_s at most. The bound falls for as long as F >= F_s,
/// and rises only while F < F_s, which it does not touch: a hand gets back no energy that it has not put in.
/// From cold, all of the peak is there for -kTime ln(1 - F_s^2 / (2 F_p^2)): 0.32 s where it is 4 F_s, 1.3 s
/// where it is 2 F_s.
class SustainedLimit {
 public:
  /// \param peak F_p. >= 0 \param sustained F_s; 0: as much as the peak, and nothing is limited
  SustainedLimit(double peak, double sustained)
      : peak_(peak), sustained_(sustained > 0.0 ? std::min(sustained, peak) : peak) {}

  /// `sent` was held for `passed`. Unit: [N] or [N m], [s].
  void pass(double sent, double passed) {
    if (sustained_ == peak_) return;
    const double ratio = sent / sustained_;
    heat_ += -std::expm1(-passed / kTime) * (ratio * ratio - heat_);
  }

  /// The most that may be sent now.
  double bound() const {
    return sustained_ + (peak_ - sustained_) * std::clamp(2.0 * (1.0 - heat_), 0.0, 1.0);
  }

  /// Time constant of the windings of small motors, which is shorter than that of their housing; assumed.
  /// Unit: [s].
  static constexpr double kTime = 10.0;

 private:
  double peak_, sustained_;
  double heat_ = 0.0;  ///< h
};

}  // namespace palpate
