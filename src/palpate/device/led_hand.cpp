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

/// Remaining offset after `dt`: reaches zero in finite time.
Vector3d rest_of(const Vector3d& way, double dt, double least_speed) {
  const double length = way.norm();
  const double gone = std::max(-std::expm1(-dt / LedHand::kFollow) * length, least_speed * dt);
  return gone < length ? Vector3d(way * (1.0 - gone / length)) : Vector3d(Vector3d::Zero());
}

}  // namespace

void LedHand::Trail::add(const Pose& pose) {
  const auto is_near = [&](const Pose& p) { return (p.position - pose.position).norm() < stride_; };
  if (empty()) stride_ = kStride;
  if (!empty() && is_near(last())) return;
  const auto first = places_.begin(), end = first + static_cast<std::ptrdiff_t>(size_);
  const auto met = std::find_if(first, end, is_near);
  if (met != end) {
    size_ = static_cast<std::size_t>(met - first) + 1;
    return;
  }
  if (size_ == places_.size()) {  // keeps every other one, and the first
    for (std::size_t i = 0; 2 * i < size_; ++i) places_[i] = places_[2 * i];
    size_ /= 2;
    stride_ *= 2.0;
  }
  places_[size_++] = pose;
}

/// One step of the return. \returns false once the hand is where it left its own path
bool LedHand::go_back(const Pose& own, double dt) {
  const bool elsewhere = (own.position - own_before_.position).norm() > kStride;
  if (elsewhere) trail_.clear();
  for (double left = kBackSpeed * dt; !trail_.empty();) {
    const Vector3d way = trail_.last().position - pose_.position;
    const Vector3d turn = turn_between(pose_.orientation, trail_.last().orientation);
    const double length = std::max(way.norm(), turn.norm() * kBackSpeed / kTurnSpeed);
    if (length > left) {
      const double share = left / length;
      pose_.position += share * way;
      pose_.orientation = (rotation_by(share * turn) * pose_.orientation).normalized();
      return true;
    }
    pose_ = trail_.last();
    left -= length;
    trail_.drop_last();
  }
  return false;
}

Pose LedHand::operator()(double t) {
  const std::optional<Pose> led = lead_(t);
  const double dt = started_ ? t - t_ : 0.0;
  if (!started_) own_t_ = t;
  if (!led && trail_.empty()) own_t_ += dt;
  const Pose goal = led ? *led : own_(own_t_);
  t_ = t;
  if (!led && !trail_.empty() && go_back(goal, dt)) return pose_;
  if (led && started_ && trail_.empty()) trail_.add(pose_);
  // The external target moves in steps and is followed smoothly; the own path is smooth, and is joined while
  // it continues.
  const Pose from = led || led_before_ ? goal : own_before_;
  const bool jumped = (goal.position - from.position).norm() > kJump * dt ||
                      turn_between(from.orientation, goal.orientation).norm() > kTurnJump * dt;
  led_before_ = led.has_value();
  if (!led) own_before_ = goal;
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
  if (led) trail_.add(pose_);
  return pose_;
}

}  // namespace palpate
