#include <palpate/device/giant_device.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include <palpate/base/error.h>
#include <palpate/device/simulated_device.h>
#include <palpate/geometry/rotation.h>
#include <palpate/kinematics/inverse_kinematics.h>

namespace palpate {
namespace {

DeviceCapabilities capabilities_of(const SerialChain& chain, const GiantProperties& properties) {
  DeviceCapabilities can;
  can.name = chain.name;
  can.kind = Causality::kAdmittance;
  can.force_max = properties.sensor.range;
  can.torque_max = properties.sensor.torque_range;
  can.actuated = {3, 3};
  can.delay = properties.delay;
  can.watchdog = GiantDevice::kWatchdog;
  can.workspace = 1.0;
  return can;
}

}  // namespace

GiantDevice::GiantDevice(const SerialChain& chain, std::unique_ptr<JointPlant> plant,
                         const GiantProperties& properties, const Pose& start, std::uint64_t seed)
    : chain_(chain),
      properties_(properties),
      capabilities_(capabilities_of(chain, properties)),
      plant_(std::move(plant)),
      motion_(chain_, properties.motion),
      kinematics_(chain_),
      random_(seed) {
  check_chain(chain_, chain.name);
  if (!(properties.delay >= 0.0 && properties.delay <= kMostDelay))
    throw Error("{}: its delay is {} s; it must be 0 to {}", chain.name, properties.delay, kMostDelay);
  const auto q = inverse_kinematics(chain_, start, motion_.limits().rest);
  if (!q.has_value())
    throw Error("{}: cannot reach {:.3f}, {:.3f}, {:.3f} in that orientation; choose another start pose",
                chain.name, start.position.x(), start.position.y(), start.position.z());
  motion_.start(*q);
  for (Told& told : told_) told.q = motion_.position();
}

/// The drives follow the setpoints of `delay` ago.
void GiantDevice::advance(double t) {
  while (shown_ + 1 < told_count_ + 1) {
    const Told& next = told_[shown_ % told_.size()];
    const double due = next.t + properties_.delay;
    if (due > t) break;
    plant_->advance(due, told_[(shown_ + told_.size() - 1) % told_.size()].q);
    ++shown_;
  }
  plant_->advance(t, told_[(shown_ + told_.size() - 1) % told_.size()].q);
}

Wrench GiantDevice::sensed(double dt) {
  const ForceSensorProperties& sensor = properties_.sensor;
  const Wrench truth = plant_->hand();
  const double share = sensor.lag > 0.0 ? -std::expm1(-dt / sensor.lag) : 1.0;
  filtered_.force += share * (truth.force - filtered_.force);
  filtered_.torque += share * (truth.torque - filtered_.torque);
  Wrench told = filtered_;
  told.force += sensor.bias.force + t_ * sensor.drift.force;
  told.torque += sensor.bias.torque + t_ * sensor.drift.torque;
  for (Eigen::Index k = 0; k < 3; ++k) {
    told.force[k] = std::clamp(told.force[k] + sensor.noise * normal_(random_), -sensor.range, sensor.range);
    told.torque[k] = std::clamp(told.torque[k] + sensor.torque_noise * normal_(random_), -sensor.torque_range,
                                sensor.torque_range);
  }
  return told;
}

bool GiantDevice::read(double t, MotionReading& reading) {
  if (started_ && !(t > read_at_)) return false;
  if (!started_ || t - t_ > SimulatedDevice::kLongestGap) {
    plant_->start(motion_.position(), t);
    moved_at_ = t_ = t;
    shown_ = told_count_;
    if (told_count_ > 0) told_[(told_count_ - 1) % told_.size()].q = motion_.position();
  }
  const double dt = t - t_;
  watchdog_braked_ = t - moved_at_ > kWatchdog;
  if (watchdog_braked_) {
    motion_.brake(dt);
    told_[told_count_++ % told_.size()] = {t_, motion_.position()};
  }
  advance(t);
  t_ = t;
  JointVector q = plant_->position();
  if (properties_.resolution > 0.0)
    for (Eigen::Index i = 0; i < q.size(); ++i)
      q[i] = properties_.resolution * std::round(q[i] / properties_.resolution);
  kinematics_.set(q);
  if (started_ && dt > 0.0) {
    const double share = -std::expm1(-dt / SimulatedDevice::kVelocityFilter);
    const Vector6d v = difference(seen_, kinematics_.tip()) / dt;
    velocity_.linear += share * (v.head<3>() - velocity_.linear);
    velocity_.angular += share * (v.tail<3>() - velocity_.angular);
  }
  seen_ = kinematics_.tip();
  read_at_ = t;
  started_ = true;
  reading = {t, DevicePose(seen_), velocity_, sensed(dt), t};
  return true;
}

MotionAnswer GiantDevice::move(const MotionSetpoint& motion, double dt) {
  const Twist before = motion_.tip_velocity();
  const bool late = std::exchange(watchdog_braked_, false);
  if (late) {
    // The joints have braked up to now.
  } else if (stopped_.load(std::memory_order_relaxed)) {
    motion_.brake(dt);
    if (motion_.velocity().isZero(0.0)) stopped_.store(false, std::memory_order_relaxed);
  } else if (motion.still) {
    motion_.brake(dt);  // includes null-space motion
  } else {
    motion_.step(motion.pose.in_device_frame(), dt);
  }
  moved_at_ = t_;
  told_[told_count_++ % told_.size()] = {t_, motion_.position()};
  MotionAnswer answer;
  answer.motion.pose = DevicePose(motion_.tip());
  answer.motion.velocity = motion_.tip_velocity();
  if (dt > 0.0) {
    const Twist& now = answer.motion.velocity;
    answer.motion.acceleration = {(now.linear - before.linear) / dt, (now.angular - before.angular) / dt};
  }
  answer.held = late || motion_.held_by() != HeldBy::kNothing || stopped_.load(std::memory_order_relaxed);
  answer.reason = late ? "commands were late" : to_string(motion_.held_by()).data();
  answer.joint = motion_.held_joint();
  if (answer.held) motion_.go_on_from_tip();
  return answer;
}

Pose GiantDevice::pose() const {
  kinematics_.set(plant_->position());
  return kinematics_.tip();
}

AdmittanceLoopModel loop_model(const SerialChain& chain, const GiantProperties& properties) {
  AdmittanceLoopModel model;
  model.delay = properties.delay;
  model.lag = 1.0 / properties.drives.bandwidth;
  model.sensor_lag = properties.sensor.lag;
  // Of all joints together: the slowest mode, in the rest posture. Damping is proportional to stiffness.
  const JointPlantFigures figures(chain, properties.drives);
  ChainKinematics at(chain);
  at.set(ChainLimits(chain).rest);
  const Eigen::MatrixXd K = figures.stiffness.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(K, Eigen::MatrixXd(at.inertia()),
                                                                        Eigen::EigenvaluesOnly);
  model.resonance = std::sqrt(modes.eigenvalues()[0]);
  model.resonance_damping =
      properties.drives.resonance_damping * model.resonance / properties.drives.resonance;
  return model;
}

}  // namespace palpate
