#include <palpate/servo/admittance_controller.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

double wanted_acceleration(double force, double mass, double damping, const AxisState& s, double dt) {
  return (force - damping * (s.velocity + 0.5 * dt * s.acceleration)) / (mass + 0.5 * dt * damping);
}

/// Fraction of the change to the wanted damping in one tick.
double damping_share(double dt) { return std::min(1.0, dt / AdmittanceController::kDampingTime); }

/// Moves `now` towards `wanted`. \param most largest increase
void approach(double& now, double wanted, double most) { now = std::min(wanted, now + most); }

void approach(Vector3d& mass, Vector3d& damping, const Vector3d& wanted_mass, const Vector3d& wanted_damping,
              double dt) {
  // A mass that decreases during motion would supply energy if the velocity were kept; here the virtual mass
  // is in the denominator, so that its momentum is lost, and its energy with it.
  for (Index k = 0; k < 3; ++k) {
    approach(mass[k], wanted_mass[k], dt * damping[k]);
    damping[k] += damping_share(dt) * (wanted_damping[k] - damping[k]);
  }
}

/// stopping(), with the position after `travel` at most.
AxisState braked(const AxisState& state, const AxisLimits& limits, double dt, double travel) {
  AxisState s = stopping(state, limits, dt);
  if (dt > travel) s.position = stopping(state, limits, travel).position;
  return s;
}

}  // namespace

AxisLimits MotionLimits::along(Index axis) const {
  AxisLimits limits{jerk, acceleration, velocity};
  if (workspace.isEmpty()) return limits;
  limits.lower = workspace.min()[axis];
  limits.upper = workspace.max()[axis];
  return limits;
}

double MotionLimits::stop_time() const {
  return std::max(palpate::stop_time(along(0)), palpate::stop_time(about()));
}

AdmittanceController::AdmittanceController(const Admittance& admittance, const MotionLimits& limits)
    : limits_(limits), now_(admittance), wanted_(admittance) {}

void AdmittanceController::start(const DevicePose& pose) {
  motion_ = {};
  motion_.pose = pose;
  for (Index k = 0; k < 3; ++k) along_[static_cast<std::size_t>(k)] = {pose.position[k], 0.0, 0.0};
}

void AdmittanceController::follow(const MotionSetpoint& actual) {
  motion_ = actual;
  for (Index k = 0; k < 3; ++k) {
    double &along = motion_.acceleration.linear[k], &about = motion_.acceleration.angular[k];
    along = std::clamp(along, -limits_.acceleration, limits_.acceleration);
    about = std::clamp(about, -limits_.angular_acceleration, limits_.angular_acceleration);
    along_[static_cast<std::size_t>(k)] = {actual.pose.position[k], actual.velocity.linear[k], along};
  }
}

void AdmittanceController::change(double dt) {
  approach(now_.mass, now_.damping, wanted_.mass, wanted_.damping, dt);
  approach(now_.inertia, now_.angular_damping, wanted_.inertia, wanted_.angular_damping, dt);
}

/// \param turned rotation about each axis since the last call, which started from 0
void AdmittanceController::tell(const Axes& turned) {
  Vector3d turn;
  for (Index k = 0; k < 3; ++k) {
    const AxisState &x = along_[static_cast<std::size_t>(k)], &a = turned[static_cast<std::size_t>(k)];
    motion_.pose.position[k] = x.position;
    motion_.velocity.linear[k] = x.velocity;
    motion_.acceleration.linear[k] = x.acceleration;
    turn[k] = a.position;
    motion_.velocity.angular[k] = a.velocity;
    motion_.acceleration.angular[k] = a.acceleration;
  }
  motion_.pose.orientation = (rotation_by(turn) * motion_.pose.orientation).normalized();
}

/// F_scene - B n n^T v. At most halves the velocity, so that every M > 0 and B are stable.
Vector3d AdmittanceController::damped(const Vector3d& scene, double dt) {
  const double size = scene.norm();
  contact_damping_ += damping_share(dt) * ((size > 0.0 ? wanted_.contact_damping : 0.0) - contact_damping_);
  if (!(size > 0.0)) return scene;
  const Vector3d n = scene / size;
  const double mass = n.dot(now_.mass.cwiseProduct(n));
  const double damping = std::min(contact_damping_, 0.5 * mass / dt);
  return scene - damping * n.dot(motion_.velocity.linear) * n;
}

const MotionSetpoint& AdmittanceController::step(const Wrench& user, const Wrench& scene, double dt) {
  change(dt);
  motion_.still = false;
  const Vector3d force = user.force + damped(scene.force, dt), torque = user.torque + scene.torque;
  Axes turned;
  for (Index k = 0; k < 3; ++k) {
    AxisState& x = along_[static_cast<std::size_t>(k)];
    x = stepped(x, limits_.along(k), wanted_acceleration(force[k], now_.mass[k], now_.damping[k], x, dt), dt);
    const AxisState a{0.0, motion_.velocity.angular[k], motion_.acceleration.angular[k]};
    turned[static_cast<std::size_t>(k)] =
        stepped(a, limits_.about(),
                wanted_acceleration(torque[k], now_.inertia[k], now_.angular_damping[k], a, dt), dt);
  }
  tell(turned);
  return motion_;
}

const MotionSetpoint& AdmittanceController::brake(double dt, double travel) {
  change(dt);
  Axes turned;
  for (Index k = 0; k < 3; ++k) {
    AxisState& x = along_[static_cast<std::size_t>(k)];
    x = braked(x, limits_.along(k), dt, travel);
    turned[static_cast<std::size_t>(k)] = braked(
        {0.0, motion_.velocity.angular[k], motion_.acceleration.angular[k]}, limits_.about(), dt, travel);
  }
  tell(turned);
  motion_.still = at_rest();
  return motion_;
}

bool AdmittanceController::at_rest() const {
  const auto none = [](const Twist& t) { return t.linear.isZero(0.0) && t.angular.isZero(0.0); };
  return none(motion_.velocity) && none(motion_.acceleration);
}

}  // namespace palpate
