#include <palpate/servo/passivity.h>

#include <algorithm>
#include <cmath>

namespace palpate {

double passive_stiffness(double damping, double virtual_damping, double period, double delay) {
  return std::max(0.0, damping - std::abs(virtual_damping)) / (0.5 * period + delay);
}

PassivityController::PassivityController(double period, double damping, double damping_max)
    : period_(period), damping_(damping), damping_max_(damping_max) {}

void PassivityController::reset() {
  started_ = false;
  stored_ = excess_ = added_ = held_ = 0.0;
}

Wrench PassivityController::correct(const Wrench& wanted, double stored, const Wrench& sent,
                                    const Pose& pose) {
  if (!started_) {
    started_ = true;
    pose_ = pose;
    stored_ = stored;
    return wanted;
  }
  const Eigen::Vector3d way = pose.position - pose_.position;
  const Eigen::AngleAxisd turn(pose.orientation * pose_.orientation.conjugate());
  const auto work = [&](const Wrench& w) {
    return w.force.dot(way) + turn.angle() * w.torque.dot(turn.axis());
  };
  const double squared = way.squaredNorm();
  const double sampling = 0.5 * (work(sent) - work(wanted));
  const double absorbed = std::clamp(sampling, 0.0, damping_ * squared / period_);
  held_ -= work(sent) - absorbed;
  put_out_ += std::max(0.0, -held_);
  held_ = std::clamp(held_, 0.0, stored);
  pose_ = pose;
  added_ = 0.0;
  if (std::isinf(stored)) return wanted;

  excess_ = std::max(0.0, excess_ + work(sent) - absorbed + stored - stored_);
  stored_ = stored;

  if (excess_ == 0.0 || squared == 0.0) return wanted;
  added_ = std::min(damping_max_, excess_ * period_ / squared);  // D = alpha |v|^2 T
  Wrench damped = wanted;
  damped.force -= added_ / period_ * way;
  return damped;
}

}  // namespace palpate
