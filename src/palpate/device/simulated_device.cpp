#include <palpate/device/simulated_device.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

Vector3d rounded(const Vector3d& v, double to) {
  return to > 0.0 ? Vector3d(to * (v / to).array().round()) : v;
}

Vector3d clamped(const Vector3d& v, double longest) {
  const double norm = v.norm();
  return norm > longest ? Vector3d(v * (longest / norm)) : v;
}

/// Velocity after a step of h: the hand's spring and all dampers implicit, dry friction limited to what stops
/// the motion. \param lag from the handle to the hand, at the beginning
Vector3d stepped(const Vector3d& v, double h, double mass, const Vector3d& force, const Vector3d& lag,
                 const Vector3d& hand_velocity, const HandProperties& hand, double damping, double coulomb) {
  const double inertia = mass + h * (damping + hand.damping) + h * h * hand.stiffness;
  const Vector3d impulse =
      mass * v + h * (force + hand.stiffness * (lag + h * hand_velocity) + hand.damping * hand_velocity);
  const double size = impulse.norm();
  return size <= h * coulomb ? Vector3d(Vector3d::Zero())
                             : Vector3d(impulse * ((1.0 - h * coulomb / size) / inertia));
}

}  // namespace

SimulatedDevice::SimulatedDevice(const DeviceCapabilities& capabilities, const PlantProperties& plant,
                                 const HandProperties& hand, HandPath path)
    : capabilities_(capabilities), plant_(plant), hand_(hand), path_(std::move(path)) {
  set_status(DeviceStatus::kEnabled);
}

void SimulatedDevice::enable() {
  stop();  // earlier forces are not rendered
  HapticDevice::enable();
}

Wrench SimulatedDevice::motors() const {
  const bool off = status() != DeviceStatus::kEnabled || stopped_.load(std::memory_order_relaxed);
  if (off || written_ == 0) return {};
  const double silent = t_ - writes_[(written_ - 1) % writes_.size()].t;
  if (capabilities_.watchdog > 0.0 && silent > capabilities_.watchdog) return {};
  const std::size_t oldest = written_ > writes_.size() ? written_ - writes_.size() : 0;
  for (std::size_t k = written_; k > oldest; --k) {
    const Written& w = writes_[(k - 1) % writes_.size()];
    if (w.t > t_ - plant_.delay) continue;
    return {clamped(w.wrench.force, capabilities_.force_max),
            clamped(w.wrench.torque, capabilities_.torque_max)};
  }
  return {};
}

void SimulatedDevice::write(const Wrench& wrench) {
  writes_[written_++ % writes_.size()] = {read_at_, wrench};
  stopped_.store(false, std::memory_order_relaxed);
}

void SimulatedDevice::step(double h) {
  const Pose wanted = path_(t_ + h);
  const Vector3d hand_velocity = (wanted.position - wanted_.position) / h;
  const Wrench shown = motors();
  const Vector3d before = velocity_.linear;
  velocity_.linear =
      stepped(before, h, plant_.mass + hand_.mass, shown.force, wanted_.position - pose_.position,
              hand_velocity, hand_, plant_.damping, plant_.coulomb);
  // Averages both ends of the step: with one end alone, the force would act half a step too soon or too late,
  // which is a twentieth of what makes a wall active.
  const Vector3d moved = 0.5 * h * (before + velocity_.linear);
  pose_.position += moved;
  hand_force_ = hand_.stiffness * (wanted.position - pose_.position) +
                hand_.damping * (hand_velocity - velocity_.linear);
  turn(h, shown.torque, wanted, turn_between(wanted_.orientation, wanted.orientation) / h);
  motor_work_ += shown.force.dot(moved) + h * shown.torque.dot(velocity_.angular);
  wanted_ = wanted;
  t_ += h;
}

void SimulatedDevice::turn(double h, const Vector3d& torque, const Pose& wanted,
                           const Vector3d& wanted_spin) {
  if (capabilities_.torque_max == 0.0) {
    pose_.orientation = wanted.orientation;
    velocity_.angular = wanted_spin;
    return;
  }
  const double squared = plant_.gyration * plant_.gyration;
  const HandProperties grip{squared * hand_.mass, squared * hand_.damping, squared * hand_.stiffness};
  const Vector3d lag = turn_between(pose_.orientation, wanted_.orientation);
  velocity_.angular = stepped(velocity_.angular, h, squared * plant_.mass + grip.mass, torque, lag,
                              wanted_spin, grip, squared * plant_.damping, plant_.gyration * plant_.coulomb);
  pose_.orientation = (rotation_by(h * velocity_.angular) * pose_.orientation).normalized();
}

bool SimulatedDevice::read(double t, DeviceReading& reading) {
  if (started_ && !(t > read_at_)) return false;
  if (!started_ || t - t_ > kLongestGap) {
    pose_ = wanted_ = path_(t);
    velocity_ = {};
    t_ = t;
  }
  const auto steps =
      static_cast<int>(std::ceil((t - t_) / kStep - 1e-6));  // few: t_ is at most kLongestGap ago
  const double h = steps > 0 ? (t - t_) / steps : 0.0;
  for (int k = 0; k < steps; ++k) step(h);
  t_ = t;  // exactly, without rounding

  Pose seen;
  seen.position = rounded(pose_.position, plant_.resolution);
  if (capabilities_.sensed.rotation > 0) {
    seen.orientation =
        rotation_by(rounded(rotation_vector(pose_.orientation), plant_.turn_resolution)).normalized();
  }
  if (started_) {
    const double dt = t - read_at_, share = -std::expm1(-dt / kVelocityFilter);
    told_velocity_.linear += share * ((seen.position - told_.position) / dt - told_velocity_.linear);
    told_velocity_.angular +=
        share * (turn_between(told_.orientation, seen.orientation) / dt - told_velocity_.angular);
  }
  told_ = seen;
  read_at_ = t;
  started_ = true;
  reading = {t, DevicePose(told_), told_velocity_};
  return true;
}

}  // namespace palpate
