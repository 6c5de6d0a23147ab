#include <palpate/device/led_hand.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

Vector3d shortened(const Vector3d& v, double most) {
  const double length = v.norm();
  return length > most ? Vector3d(v * (most / length)) : v;
}

/// What is left of a way after `dt`: it is gone in the end.
Vector3d rest_of(const Vector3d& way, double dt, double least_speed) {
  const double length = way.norm();
  const double gone = std::max(-std::expm1(-dt / LedHand::kFollow) * length, least_speed * dt);
  return gone < length ? Vector3d(way * (1.0 - gone / length)) : Vector3d(Vector3d::Zero());
}

}  // namespace

Pose LedHand::operator()(double t) {
  const std::optional<Pose> led = lead_(t);
  const Pose goal = led ? *led : own_(t);
  const double dt = started_ ? t - t_ : 0.0;
  t_ = t;
  // What leads comes in steps, which are followed smoothly; its own way is smooth, and joined while it goes
  // on.
  const Pose from = led || led_before_ ? goal : own_before_;
  const bool jumped = (goal.position - from.position).norm() > kJump * dt ||
                      turn_between(from.orientation, goal.orientation).norm() > kTurnJump * dt;
  led_before_ = led.has_value();
  own_before_ = goal;
  if (led || (started_ && jumped)) away_ = true;
  if (!started_ || !away_) {
    started_ = true;
    return pose_ = goal;
  }
  const Vector3d off = rest_of(pose_.position - from.position, dt, kLeastShare * kSpeed);
  const Vector3d turned =
      rest_of(turn_between(from.orientation, pose_.orientation), dt, kLeastShare * kTurnSpeed);
  const Vector3d way = goal.position + off - pose_.position;
  const Eigen::Quaterniond there = rotation_by(turned) * goal.orientation;
  const Vector3d turn = turn_between(pose_.orientation, there);
  const bool arrives =
      off.isZero(0.0) && turned.isZero(0.0) && way.norm() <= kSpeed * dt && turn.norm() <= kTurnSpeed * dt;
  if (arrives && !led) {
    away_ = false;
    return pose_ = goal;
  }
  pose_.position += shortened(way, kSpeed * dt);
  pose_.orientation = (rotation_by(shortened(turn, kTurnSpeed * dt)) * pose_.orientation).normalized();
  return pose_;
}

}  // namespace palpate
