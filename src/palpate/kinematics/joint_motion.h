/// \file
/// Velocity inverse kinematics within the limits of the joints: serial kinematic rendering.
#pragma once

#include <cstdint>
#include <string_view>

#include <palpate/kinematics/box_least_squares.h>
#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {

/// Why the TCP is not where it was asked to be.
enum class HeldBy : std::uint8_t {
  kNothing,
  kPosition,      ///< a joint is at the end of its way
  kVelocity,      ///< a joint is as fast as it may be
  kAcceleration,  ///< a joint takes up speed, or brakes, as fast as it may
  kSingular,      ///< no joint moves the TCP in the direction that was asked for
  kNotFinite,     ///< what was asked for is no pose
};
std::string_view to_string(HeldBy why);

/// How the joints share what the TCP does.
struct JointMotionOptions {
  double length = 0.3;            ///< a radian counts as much as so many metres. Unit: [m]. > 0
  double centring = 2.0;          ///< rate at which redundancy goes to ChainJoint::rest. Unit: [1/s].
  double centring_weight = 1e-3;  ///< of that against the TCP's motion, of 1
  double singular_below = 0.3;    ///< singular value of W J D below which motion is damped
  double damping = 0.1;           ///< lambda at a singular value of 0
  double lag_damping = 0.5;  ///< of lambda^2, for each metre that the TCP has fallen behind. Unit: [1/m].
  /// How a TCP that has fallen behind catches up, a radian as `length`. Unit: [m/s], [m/s^2].
  double catch_up_speed = 1.0, catch_up_acceleration = 5.0;
  double jump_speed = 10.0;  ///< of targets: faster is a jump, which is caught up with. Unit: [m/s].
  double followed = 1e-3;    ///< lag that is no reason to tell HeldBy. Unit: [m], a radian as `length`.
};

/// Joint motion that takes the TCP along a path. Each tick solves
///
///     min |W (J dq - V)|^2 + |D^-1 dq|^2 lambda^2 + |D^-1 U (dq - c (q_rest - q))|^2 w^2
///     lower <= dq <= upper                                                       (least_in_box())
///
/// where V is the target's own velocity and what catches up with it, W = diag(1, 1, 1, length, ...) and D are
/// the joints' velocity limits. U keeps joints from their ends as long as others can do the work: it grows
/// from 1 in the middle of a joint's way (Chan and Dubey 1995). lambda^2 is what is due to a singularity,
/// from 0 to `damping`^2 as the least singular value of W J D falls from `singular_below` to 0 (Nakamura and
/// Hanafusa 1986), and to a TCP that has fallen behind (Sugihara 2011): towards what it cannot reach it goes
/// as near as it can, and rests. The bounds are those of velocity, of acceleration, and of what can still be
/// braked before the end of the joint's way, from d away within dt and with deceleration a:
///
///     dq dt + dq^2 / (2 a) <= d       <=>       dq <= a (sqrt(dt^2 + 2 d / a) - dt)
///
/// If dq kept to that, so does dq - a dt' in the next tick, whatever dt' is: the box is never empty, and
/// position, velocity and acceleration are kept at every tick. Torque limits are limits of acceleration, by
/// limit_by_effort().
///
/// One object a thread. Takes nothing from the heap after its construction, throws nothing.
class JointMotion {
 public:
  /// \param chain checked; must outlive the object.
  explicit JointMotion(const SerialChain& chain, const JointMotionOptions& options = {});

  /// At rest there; positions beyond a limit are taken to it. \param q Shape: [joints].
  void start(const JointVector& q);

  /// The next joint positions on the way of the TCP to `target`. Holds where that is not finite.
  /// \param target base's frame \param dt since the last call. Unit: [s]. > 0; 0 does nothing
  void step(const Pose& target, double dt);
  /// Brings all joints to rest, each as fast as it may.
  void brake(double dt);

  const JointVector& position() const { return q_; }
  const JointVector& velocity() const { return dq_; }
  const JointVector& acceleration() const { return ddq_; }
  /// Where these take the TCP, and how it moves. Base's frame.
  const Pose& tip() const { return kinematics_.tip(); }
  Twist tip_velocity() const;

  /// What keeps the TCP more than `followed` from the last target, and which joint; -1: none in particular.
  HeldBy held_by() const { return held_by_; }
  int held_joint() const { return held_joint_; }
  /// From the TCP to the last target. Unit: [m], [rad].
  const Vector6d& lag() const { return lag_; }
  /// The least singular value of W J D at the last step: how far from a singularity.
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
  JointVector position_lower_, position_upper_;  ///< of dq, by the ends of the way
  BoxProblem problem_;
  Pose target_;  ///< of the last step
  Vector6d lag_ = Vector6d::Zero();
  double singular_ = 0.0;
  HeldBy held_by_ = HeldBy::kNothing;
  int held_joint_ = -1;
};

}  // namespace palpate
