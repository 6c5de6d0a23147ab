/// \file
/// Velocity inverse kinematics within the limits of the joints: serial kinematic rendering.
#pragma once

#include <cstdint>
#include <string_view>

#include <palpate/kinematics/box_least_squares.h>
#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {

/// Why the TCP is not at its target.
enum class HeldBy : std::uint8_t {
  kNothing,
  kPosition,      ///< a joint is at a position limit
  kVelocity,      ///< a joint is at its velocity limit
  kAcceleration,  ///< a joint is at its acceleration limit
  kSingular,      ///< no joint moves the TCP in the requested direction
  kNotFinite,     ///< the target is not finite
};
std::string_view to_string(HeldBy why);

/// Weights and rates of the redundancy resolution.
struct JointMotionOptions {
  double length = 0.3;    ///< metres that count as much as one radian. Unit: [m]. > 0
  double centring = 2.0;  ///< rate at which redundant motion approaches ChainJoint::rest. Unit: [1/s].
  double centring_weight = 1e-3;  ///< weight of centring; that of the TCP's motion is 1
  double singular_below = 0.3;    ///< singular value of W J D below which motion is damped
  double damping = 0.1;           ///< lambda at a singular value of 0
  double lag_damping = 0.5;       ///< of lambda^2, per metre of lag of the TCP. Unit: [1/m].
  /// Limits with which a lagging TCP catches up; radians are weighted by `length`. Unit: [m/s], [m/s^2].
  double catch_up_speed = 1.0, catch_up_acceleration = 5.0;
  double jump_speed = 10.0;  ///< a faster target is a jump, which is caught up with. Unit: [m/s].
  double followed = 1e-3;    ///< lag up to which HeldBy is kNothing. Unit: [m], radians by `length`.
};

/// Joint motion that moves the TCP along a path. Each tick solves
///
///     min |W (J dq - V)|^2 + |D^-1 dq|^2 lambda^2 + |D^-1 U (dq - c (q_rest - q))|^2 w^2
///     lower <= dq <= upper                                                       (least_in_box())
///
/// where V is the target's own velocity plus a catch-up velocity, W = diag(1, 1, 1, length, ...) and D are
/// the joints' velocity limits. U keeps joints away from their limits as long as others can do the work: it
/// grows from 1 in the middle of a joint's range (Chan and Dubey 1995). lambda^2 is the sum of a singularity
/// term, from 0 to `damping`^2 as the least singular value of W J D falls from `singular_below` to 0
/// (Nakamura and Hanafusa 1986), and a lag term (Sugihara 2011): the TCP approaches an unreachable target as
/// closely as possible, and rests. The bounds are those of velocity, of acceleration, and of the velocity
/// from which a joint can still brake before its limit, at distance d, within dt and with deceleration a:
///
///     dq dt + dq^2 / (2 a) <= d       <=>       dq <= a (sqrt(dt^2 + 2 d / a) - dt)
///
/// If dq satisfies this, so does dq - a dt' in the next tick, whatever dt' is: the box is never empty, and
/// position, velocity and acceleration limits hold at every tick. limit_by_effort() turns torque limits into
/// acceleration limits.
///
/// One object per thread. No heap allocation after construction; throws nothing.
class JointMotion {
 public:
  /// \param chain valid by check_chain(); must outlive the object.
  explicit JointMotion(const SerialChain& chain, const JointMotionOptions& options = {});

  /// Resets the state to rest at `q`; positions beyond a limit are clamped to it. \param q Shape: [joints].
  void start(const JointVector& q);

  /// Computes the next joint positions on the way of the TCP to `target`. Holds if that is not finite. \param
  /// target base's frame \param dt since the last call. Unit: [s]. > 0; 0 does nothing
  void step(const Pose& target, double dt);
  /// Lets the path go on from the TCP instead of from the last target: for callers that were told that it
  /// lags and continue from where it is. Otherwise the way back would count as the target's own motion.
  void go_on_from_tip() { target_ = tip(); }
  /// Brakes all joints to rest, each at its acceleration limit.
  void brake(double dt);

  const JointVector& position() const { return q_; }
  const JointVector& velocity() const { return dq_; }
  const JointVector& acceleration() const { return ddq_; }
  /// Pose and velocity of the TCP at these joint positions and velocities. Base's frame.
  const Pose& tip() const { return kinematics_.tip(); }
  Twist tip_velocity() const;

  /// Why the TCP is more than `followed` from the last target, and which joint limits it; -1: none in
  /// particular.
  HeldBy held_by() const { return held_by_; }
  int held_joint() const { return held_joint_; }
  /// From the TCP to the last target. Unit: [m], [rad].
  const Vector6d& lag() const { return lag_; }
  /// Least singular value of W J D at the last step: the distance from a singularity.
  double least_singular_value() const { return singular_; }

  const ChainLimits& limits() const { return limits_; }

 private:
  void bound(double dt);
  void move(const JointVector& dq, double dt);
  void explain();
  Vector6d wanted_velocity(const Pose& target, double dt) const;
  double size(const Vector6d& v) const;
  double end_weight(Eigen::Index i) const;
  void pose_problem(const Vector6d& velocity);

  const SerialChain* chain_;
  ChainLimits limits_;
  JointMotionOptions options_;
  ChainKinematics kinematics_;
  JointVector q_, dq_, ddq_;
  JointVector position_lower_, position_upper_;  ///< bounds of dq due to position limits
  BoxProblem problem_;
  Pose target_;  ///< of the last step
  Vector6d lag_ = Vector6d::Zero();
  double singular_ = 0.0;
  HeldBy held_by_ = HeldBy::kNothing;
  int held_joint_ = -1;
};

}  // namespace palpate
