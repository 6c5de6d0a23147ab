/// \file
/// Sustained force limit: thermal model of the motors.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

/// Lowers a force (or torque) from the peak to the sustained limit before the motors overheat. The heating of
/// a motor is proportional to the square of its current, and so of its force; with F the force sent, F_s the
/// sustained and F_p the peak limit,
///
///     h' = (F^2 / F_s^2 - h) / kTime        h in [0, 1]: the mean of F^2 over kTime, relative to F_s^2
///     |F| <= F_s + (F_p - F_s) min(1, 2 (1 - h))
///
/// so that h is never above 1: at h = 1, F is at most F_s. The bound decreases while F >= F_s and increases
/// only while F < F_s, where it does not limit F: the hand receives no energy that it has not put in. From
/// cold, the full peak is available for -kTime ln(1 - F_s^2 / (2 F_p^2)): 0.32 s for F_p = 4 F_s, 1.3 s for
/// F_p = 2 F_s.
class SustainedLimit {
 public:
  /// \param peak F_p. >= 0 \param sustained F_s; 0 = equal to the peak: no limitation
  SustainedLimit(double peak, double sustained)
      : peak_(peak), sustained_(sustained > 0.0 ? std::min(sustained, peak) : peak) {}

  /// Reports that `sent` was held for `passed`. Unit: [N] or [N m], [s].
  void pass(double sent, double passed) {
    if (sustained_ == peak_) return;
    const double ratio = sent / sustained_;
    heat_ += -std::expm1(-passed / kTime) * (ratio * ratio - heat_);
  }

  /// Largest force that may be sent now.
  double bound() const {
    return sustained_ + (peak_ - sustained_) * std::clamp(2.0 * (1.0 - heat_), 0.0, 1.0);
  }

  /// Thermal time constant of the windings of small motors, shorter than that of the housing; assumed. Unit:
  /// [s].
  static constexpr double kTime = 10.0;

 private:
  double peak_, sustained_;
  double heat_ = 0.0;  ///< h
};

}  // namespace palpate
