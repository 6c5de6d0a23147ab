#include <palpate/device/led_hand.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {

Pose LedHand::operator()(double t) {
  const std::optional<Pose> led = lead_(t);
  const Pose goal = led ? *led : own_(t);
  const double dt = started_ ? t - t_ : 0.0;
  t_ = t;
  if (led) on_its_way_ = false;
  if (!started_ || (on_its_way_ && !led)) {
    started_ = true;
    return pose_ = goal;
  }
  const double share = -std::expm1(-dt / kFollow);
  const auto shortened = [](const Eigen::Vector3d& v, double most) {
    const double length = v.norm();
    return length > most ? Eigen::Vector3d(v * (most / length)) : v;
  };
  const Eigen::Vector3d way = goal.position - pose_.position,
                        turn = turn_between(pose_.orientation, goal.orientation);
  pose_.position += shortened(share * way, kSpeed * dt);
  pose_.orientation =
      (rotation_by(shortened(share * turn, kTurnSpeed * dt)) * pose_.orientation).normalized();
  // What moves away from it no faster than it follows is caught up with to the way of one follow time.
  constexpr double kNear = 1e-4;
  on_its_way_ = !led && way.norm() < kNear && turn.norm() < kNear / 0.01;
  return pose_;
}

}  // namespace palpate
