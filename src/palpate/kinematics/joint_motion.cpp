#include <palpate/kinematics/joint_motion.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

/// Tolerance within which a joint is at a bound, as a fraction of its velocity limit.
constexpr double kAtLimit = 1e-6;
/// Regularization that keeps H positive definite whatever the weights, for joint velocities scaled to their
/// limits.
constexpr double kRegular = 1e-10;

/// Largest velocity from which a joint can brake within `d` at deceleration `a`; see JointMotion. \param d
/// Unit: [u]. \param a Unit: [u/s^2].
double brakeable(double d, double a, double dt) {
  return a * (std::sqrt(dt * dt + 2.0 * std::max(0.0, d) / a) - dt);
}

bool is_target(const Pose& pose) {
  return pose.position.allFinite() && std::abs(pose.orientation.norm() - 1.0) < 1e-3;
}

}  // namespace

std::string_view to_string(HeldBy why) {
  constexpr std::array<std::string_view, 6> kNames{"nothing",          "position limit",
                                                   "velocity limit",   "acceleration limit",
                                                   "singular posture", "target is not finite"};
  return kNames[static_cast<std::size_t>(why)];
}

JointMotion::JointMotion(const SerialChain& chain, const JointMotionOptions& options)
    : chain_(&chain), limits_(chain), options_(options), kinematics_(chain) {
  start(limits_.rest);
}

void JointMotion::start(const JointVector& q) {
  q_ = q.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  dq_ = ddq_ = JointVector::Zero(chain_->size());
  kinematics_.set(q_);
  target_ = kinematics_.tip();
  lag_.setZero();
  held_by_ = HeldBy::kNothing;
  held_joint_ = -1;
}

Twist JointMotion::tip_velocity() const {
  const Vector6d v = kinematics_.jacobian().lazyProduct(dq_);
  return {v.head<3>(), v.tail<3>()};
}

void JointMotion::bound(double dt) {
  const auto n = q_.size();
  for (JointVector* v : {&position_lower_, &position_upper_, &problem_.lower, &problem_.upper}) v->resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = limits_.acceleration[i];
    position_upper_[i] = brakeable(limits_.upper[i] - q_[i], a, dt);
    position_lower_[i] = -brakeable(q_[i] - limits_.lower[i], a, dt);
    double high = std::min({limits_.velocity[i], dq_[i] + a * dt, position_upper_[i]});
    double low = std::max({-limits_.velocity[i], dq_[i] - a * dt, position_lower_[i]});
    if (low > high)
      low = high = std::clamp(0.5 * (low + high), dq_[i] - a * dt, dq_[i] + a * dt);  // by rounding
    problem_.lower[i] = low;
    problem_.upper[i] = high;
  }
}

double JointMotion::size(const Vector6d& v) const {
  return std::hypot(v.head<3>().norm(), options_.length * v.tail<3>().norm());
}

Vector6d JointMotion::wanted_velocity(const Pose& target, double dt) const {
  Vector6d velocity = difference(target_, target) / dt;
  Pose from = target_;
  if (size(velocity) > options_.jump_speed) {
    velocity.setZero();
    from = target;
  }
  const Vector6d behind = difference(kinematics_.tip(), from);
  const double way = size(behind);
  if (way == 0.0) return velocity;
  const double speed =
      std::min({way / dt, options_.catch_up_speed, brakeable(way, options_.catch_up_acceleration, dt)});
  return velocity + speed / way * behind;
}

/// Square of the element of U of a joint; see JointMotion.
double JointMotion::end_weight(Eigen::Index i) const {
  constexpr double kMost = 1e4;
  const double above = q_[i] - limits_.lower[i], below = limits_.upper[i] - q_[i], way = above + below;
  const double product = above * below;
  if (!(product > 0.0)) return kMost;
  return std::min(kMost, 1.0 + std::abs(way * way * (above - below) / (4.0 * product * product)) * way);
}

void JointMotion::pose_problem(const Vector6d& velocity) {
  const auto n = q_.size();
  Vector6d weight;
  weight << 1.0, 1.0, 1.0, options_.length, options_.length, options_.length;
  Jacobian A = kinematics_.jacobian();
  for (Eigen::Index i = 0; i < n; ++i) A.col(i) = A.col(i).cwiseProduct(weight);
  Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();  // W J D (W J D)^T
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector6d column = limits_.velocity[i] * A.col(i);
    gram += column * column.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(gram, Eigen::EigenvaluesOnly);
  singular_ = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
  const double near = std::max(0.0, 1.0 - singular_ / options_.singular_below);
  const double damping =
      options_.damping * options_.damping * near * near + options_.lag_damping * size(lag_);

  const Vector6d wanted = velocity.cwiseProduct(weight);
  problem_.H.resize(n, n);
  problem_.g.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) problem_.H(i, j) = problem_.H(j, i) = A.col(i).dot(A.col(j));
    const double scale = 1.0 / (limits_.velocity[i] * limits_.velocity[i]);
    const double centring = options_.centring_weight * options_.centring_weight * end_weight(i);
    problem_.H(i, i) += (damping + centring + kRegular) * scale;
    problem_.g[i] = A.col(i).dot(wanted) + centring * scale * options_.centring * (limits_.rest[i] - q_[i]);
  }
}

void JointMotion::move(const JointVector& dq, double dt) {
  ddq_ = (dq - dq_) / dt;
  dq_ = dq;
  q_ =
      (q_ + dt * dq).cwiseMax(limits_.lower).cwiseMin(limits_.upper);  // in range already except for rounding
  kinematics_.set(q_);
}

/// Finds the active bound whose joint would otherwise contribute most to the motion towards the target.
void JointMotion::explain() {
  lag_ = difference(kinematics_.tip(), target_);
  held_by_ = HeldBy::kNothing;
  held_joint_ = -1;
  if (size(lag_) <= options_.followed) return;
  held_by_ = HeldBy::kSingular;
  const Jacobian J = kinematics_.jacobian();
  double most = 0.0;
  for (int i = 0; i < dq_.size(); ++i) {
    const double use = J.col(i).head<3>().dot(lag_.head<3>()) +
                       options_.length * options_.length * J.col(i).tail<3>().dot(lag_.tail<3>());
    const double slack = kAtLimit * limits_.velocity[i];
    const bool at_bound =
        use > 0.0 ? dq_[i] >= problem_.upper[i] - slack : dq_[i] <= problem_.lower[i] + slack;
    if (!at_bound || std::abs(use) * limits_.velocity[i] <= most) continue;
    most = std::abs(use) * limits_.velocity[i];
    held_joint_ = i;
    const double end = use > 0.0 ? position_upper_[i] : -position_lower_[i];
    const double speed = std::abs(dq_[i]);
    if (speed >= end - slack)
      held_by_ = HeldBy::kPosition;
    else if (speed >= limits_.velocity[i] - slack)
      held_by_ = HeldBy::kVelocity;
    else
      held_by_ = HeldBy::kAcceleration;
  }
}

void JointMotion::step(const Pose& target, double dt) {
  if (!(dt > 0.0)) return;
  if (!is_target(target)) {
    brake(dt);
    held_by_ = HeldBy::kNotFinite;
    held_joint_ = -1;
    return;
  }
  bound(dt);
  pose_problem(wanted_velocity(target, dt));
  move(least_in_box(problem_).x, dt);
  target_ = target;
  explain();
}

void JointMotion::brake(double dt) {
  if (!(dt > 0.0)) return;
  bound(dt);
  JointVector dq = dq_;
  for (Eigen::Index i = 0; i < dq.size(); ++i) dq[i] = std::clamp(0.0, problem_.lower[i], problem_.upper[i]);
  move(dq, dt);
  target_ = kinematics_.tip();
  lag_.setZero();
  held_by_ = HeldBy::kNothing;
  held_joint_ = -1;
}

}  // namespace palpate
