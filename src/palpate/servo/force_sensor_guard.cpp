#include <palpate/servo/force_sensor_guard.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {

std::string_view to_string(SensorFault fault) {
  constexpr std::array<std::string_view, 6> kNames{"none",      "not finite", "spike",
                                                   "saturated", "dropout",    "bias"};
  return kNames[static_cast<std::size_t>(fault)];
}

bool ForceSensorGuard::at_end(const Wrench& m) const {
  return m.force.cwiseAbs().maxCoeff() >= limits_.force_range ||
         m.torque.cwiseAbs().maxCoeff() >= limits_.torque_range;
}

SensorFault ForceSensorGuard::judge(const Wrench& m, double measured_t, double t) const {
  if (!m.force.allFinite() || !m.torque.allFinite() || !std::isfinite(measured_t))
    return SensorFault::kNotFinite;
  if (!started_) return SensorFault::kNone;
  if (!(measured_t > last_t_)) return SensorFault::kDropout;
  // Compared with the last good measurement, over the time since: after a while any value is plausible again.
  const double passed = std::min(measured_t, t) - last_t_;
  const bool leaps = (m.force - last_.force).norm() > limits_.force_rate * passed ||
                     (m.torque - last_.torque).norm() > limits_.torque_rate * passed;
  return leaps ? SensorFault::kSpike : SensorFault::kNone;
}

SensorFault ForceSensorGuard::take(const Wrench& measured, double measured_t, double t) {
  const double passed = started_ ? std::max(0.0, t - now_) : 0.0;
  now_ = t;
  const SensorFault found = judge(measured, measured_t, t);
  if (found != SensorFault::kNone) {
    if (!started_) return found;
    return t - good_at_ > limits_.hold_time ? found : SensorFault::kNone;
  }
  started_ = true;
  last_ = measured;
  last_t_ = measured_t;
  good_at_ = t;
  sum_.force += measured.force;
  sum_.torque += measured.torque;
  ++summed_;
  saturated_for_ = at_end(measured) ? saturated_for_ + passed : 0.0;
  return saturated_for_ > limits_.saturated_time ? SensorFault::kSaturated : SensorFault::kNone;
}

void ForceSensorGuard::begin_tare() {
  sum_ = {};
  summed_ = 0;
}

SensorFault ForceSensorGuard::tare() {
  if (summed_ == 0) return SensorFault::kDropout;
  const Wrench mean{sum_.force / summed_, sum_.torque / summed_};
  if (mean.force.norm() > limits_.bias_force || mean.torque.norm() > limits_.bias_torque)
    return SensorFault::kBias;
  bias_ = mean;
  return SensorFault::kNone;
}

}  // namespace palpate
