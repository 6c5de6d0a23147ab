/// \file
/// Forward kinematics, Jacobian and joint-space inertia of serial chains.
#pragma once

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// Where a chain is at joint positions q, and how its TCP moves with them. One object a thread. Takes nothing
/// from the heap, throws nothing; about 0.5 us for eight joints.
class ChainKinematics {
 public:
  /// \param chain checked by check_chain(); must outlive the object.
  explicit ChainKinematics(const SerialChain& chain);

  /// \param q Shape: [joints]. Finite; may be beyond the limits.
  void set(const JointVector& q);

  /// X_BT: of the TCP in the base's frame.
  const Pose& tip() const { return tip_; }
  /// Of the link behind joint `i`.
  const Pose& link(int i) const { return links_[static_cast<std::size_t>(i)]; }

  /// Twist of the TCP, in the base's frame and about the TCP, by joint velocities: J dq. Shape: [6, joints].
  Jacobian jacobian() const { return jacobian_at(tip_.position, static_cast<int>(links_.size())); }

  /// M(q): kinetic energy is dq^T M dq / 2; the sum of m J_v^T J_v + J_w^T I J_w over the links. Shape:
  /// [joints, joints].
  JointMatrix inertia() const;

 private:
  Jacobian jacobian_at(const Eigen::Vector3d& point, int joints) const;

  const SerialChain* chain_;
  std::vector<Pose> links_;
  std::vector<Eigen::Vector3d> axes_;    ///< unit vectors, base's frame
  std::vector<Eigen::Vector3d> places_;  ///< a point on each axis
  Pose tip_;
};

/// From a pose to another: translation, then rotation vector, in the frame that both are in. Unit: [m],
/// [rad].
Vector6d difference(const Pose& from, const Pose& to);

}  // namespace palpate
