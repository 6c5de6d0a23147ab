/// \file
/// What a force sensor says, without what no hand can do.
#pragma once

#include <string_view>

#include <palpate/geometry/pose.h>

namespace palpate {

/// What is expected of a force sensor and of the hand at it.
struct ForceSensorLimits {
  double force_range = 0.0, torque_range = 0.0;  ///< of each axis. Unit: [N], [N m]. > 0
  /// Of two measurements, the most that they are apart: a hand's blow. Unit: [N/s], [N m/s].
  double force_rate = 2e4, torque_rate = 1e3;
  double hold_time = 5e-3;  ///< for which the last good one stands in for bad or missing ones. Unit: [s].
  double saturated_time = 0.05;                ///< at the end of its range. Unit: [s].
  double bias_force = 3.0, bias_torque = 0.3;  ///< the most that is taken for bias. Unit: [N], [N m].
};

/// Why a sensor is not trusted.
enum class SensorFault { kNone, kNotFinite, kSpike, kSaturated, kDropout, kBias };
std::string_view to_string(SensorFault fault);

/// Lets through what a sensor says as long as it may be true. A spike, a NaN or a missing measurement is
/// replaced by the last good one for hold_time; what lasts longer is a fault, as are forces at the end of the
/// range. Bias is what is measured on average while nobody pushes: see tare(). Drift after that is not known,
/// and moves the handle by drift / D.
///
/// One object a thread. Takes nothing from the heap, throws nothing.
class ForceSensorGuard {
 public:
  explicit ForceSensorGuard(const ForceSensorLimits& limits) : limits_(limits) {}

  /// \param measured F_H_D, torque about the TCP, at `measured_t` \param t now. Unit: [s]. \returns what is
  /// wrong; then `wrench()` is the last good one, and not to be used
  SensorFault take(const Wrench& measured, double measured_t, double t);

  /// Of the hand, without bias: F_H_D, torque about the TCP.
  Wrench wrench() const { return {last_.force - bias_.force, last_.torque - bias_.torque}; }

  /// Begins to average what is measured.
  void begin_tare();
  /// The average since begin_tare() is the bias from now on; as far as it is plausible. \returns kBias if it
  /// is not
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
