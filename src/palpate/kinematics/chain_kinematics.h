/// \file
/// Forward kinematics, Jacobian and joint-space inertia of serial chains.
#pragma once

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// Link poses of a chain at joint positions q, and the Jacobian of its TCP. One object per thread. No heap
/// allocation after construction; throws nothing; about 0.5 us for eight joints.
class ChainKinematics {
 public:
  /// \param chain checked by check_chain(); must outlive the object.
  explicit ChainKinematics(const SerialChain& chain);

  /// \param q Shape: [joints]. Finite; may be beyond the limits.
  void set(const JointVector& q);

  /// X_BT: pose of the TCP in the base's frame.
  const Pose& tip() const { return tip_; }
  /// Pose of the link that joint `i` moves, in the base's frame.
  const Pose& link(int i) const { return links_[static_cast<std::size_t>(i)]; }

  /// Maps joint velocities to the twist of the TCP, in the base's frame and about the TCP: J dq. Shape: [6,
  /// joints].
  Jacobian jacobian() const { return jacobian_at(tip_.position, static_cast<int>(links_.size())); }

  /// Joint-space inertia M(q): kinetic energy is dq^T M dq / 2; the sum of m J_v^T J_v + J_w^T I J_w over the
  /// links. Shape: [joints, joints].
  JointMatrix inertia() const;

 private:
  Jacobian jacobian_at(const Eigen::Vector3d& point, int joints) const;

  const SerialChain* chain_;
  std::vector<Pose> links_;
  std::vector<Eigen::Vector3d> axes_;    ///< unit vectors, base's frame
  std::vector<Eigen::Vector3d> places_;  ///< a point on each axis
  Pose tip_;
};

/// Difference of two poses: translation, then rotation vector, in the common frame of both. Unit: [m], [rad].
Vector6d difference(const Pose& from, const Pose& to);

}  // namespace palpate
