#include <palpate/servo/passivity.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {

namespace {

/// Time constant after which unabsorbed energy is discarded: it has long entered the hand, and braking it
/// later would be felt as a buzz, since at low speed one encoder step is all of the velocity. Unit: [s].
constexpr double kForgotten = 0.02;

}  // namespace

double passive_stiffness(double damping, double virtual_damping, double period, double delay) {
  return std::max(0.0, damping - std::abs(virtual_damping)) / (0.5 * period + delay);
}

PassivityController::PassivityController(double period, double damping, double damping_max, double arm,
                                         double angular_damping)
    : period_(period),
      damping_(damping),
      damping_max_(damping_max),
      arm_(arm),
      angular_damping_(angular_damping) {}

void PassivityController::reset() {
  started_ = false;
  excess_ = added_ = held_ = 0.0;
}

Wrench PassivityController::correct(const Wrench& wanted, double stored, const Wrench& sent,
                                    const DevicePose& pose, double passed) {
  if (!started_) {
    started_ = true;
    pose_ = pose;
    return wanted;
  }
  const double period = std::max(passed, period_);
  const Eigen::Vector3d way = pose.position - pose_.position;
  const Eigen::Vector3d turn = turn_between(pose_.orientation, pose.orientation);
  const auto work = [&](const Wrench& w) { return w.force.dot(way) + w.torque.dot(turn); };
  const double squared = way.squaredNorm() + arm_ * arm_ * turn.squaredNorm();
  const double sampling = 0.5 * (work(sent) - work(wanted));
  const double own = damping_ * way.squaredNorm() + angular_damping_ * turn.squaredNorm();
  const double absorbed = std::clamp(sampling, 0.0, own / period);
  held_ -= work(sent) - absorbed;
  const double out = std::max(0.0, -held_);
  port_energy_ += out;
  held_ = std::clamp(held_, 0.0, stored);
  pose_ = pose;
  added_ = 0.0;
  if (std::isinf(stored)) return wanted;

  const double kept = std::exp(-passed / kForgotten);
  excess_ = std::max(0.0, kept * excess_ + sampling - absorbed + out);
  if (excess_ == 0.0 || squared == 0.0) return wanted;
  added_ = std::min(damping_max_, excess_ * period / squared);  // D = alpha |v|^2 T
  const double rate = added_ / period;
  return {wanted.force - rate * way, wanted.torque - rate * arm_ * arm_ * turn};
}

}  // namespace palpate
