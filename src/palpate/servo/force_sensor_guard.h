/// \file
/// Plausibility check and bias removal of a force sensor.
#pragma once

#include <string_view>

#include <palpate/geometry/pose.h>

namespace palpate {

/// Plausibility limits of a force sensor and the hand on it.
struct ForceSensorLimits {
  double force_range = 0.0, torque_range = 0.0;  ///< of each axis. Unit: [N], [N m]. > 0
  /// Largest rate of change between two measurements: a blow of the hand. Unit: [N/s], [N m/s].
  double force_rate = 2e4, torque_rate = 1e3;
  double hold_time =
      5e-3;  ///< during which the last good measurement replaces bad or missing ones. Unit: [s].
  /// during which measurements at the end of the range are used as they are: a blow of the hand exerts at
  /// least that. Unit: [s].
  double saturated_time = 0.05;
  double bias_force = 3.0, bias_torque = 0.3;  ///< largest plausible bias. Unit: [N], [N m].
};

/// Reason for rejecting a sensor's measurements.
enum class SensorFault { kNone, kNotFinite, kSpike, kSaturated, kDropout, kBias };
std::string_view to_string(SensorFault fault);

/// Passes plausible measurements. A spike, a NaN or a missing measurement is replaced by the last good one
/// for hold_time; a longer disturbance is a fault, as are forces at the end of the range for longer than
/// saturated_time. The bias is the mean of the measurements while nobody pushes: see tare(). Later drift is
/// unknown, and moves the handle at drift / D.
///
/// One object per thread. Does not allocate or throw.
class ForceSensorGuard {
 public:
  explicit ForceSensorGuard(const ForceSensorLimits& limits) : limits_(limits) {}

  /// Takes a measurement. \param measured F_H_D, torque about the TCP, at `measured_t` \param t now. Unit:
  /// [s]. \returns the fault; if there is one, `wrench()` is the last good one and must not be used
  SensorFault take(const Wrench& measured, double measured_t, double t);

  /// Wrench of the hand, bias removed: F_H_D, torque about the TCP.
  Wrench wrench() const { return {last_.force - bias_.force, last_.torque - bias_.torque}; }

  /// Starts averaging the measurements.
  void begin_tare();
  /// Takes the average since begin_tare() as the bias from now on. \returns kBias if it is not plausible,
  /// kDropout if there was no measurement; the bias is then unchanged
  SensorFault tare();

  const Wrench& bias() const { return bias_; }

 private:
  SensorFault judge(const Wrench& measured, double measured_t, double t) const;
  bool at_end(const Wrench& measured) const;

  ForceSensorLimits limits_;
  bool started_ = false;
  Wrench last_, bias_, sum_;
  int summed_ = 0;
  double last_t_ = 0.0, good_at_ = 0.0, saturated_for_ = 0.0, now_ = 0.0;
};

}  // namespace palpate
