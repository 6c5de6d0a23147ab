/// \file
/// Serial kinematic chains: joints, their limits, and the links that they move.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <palpate/geometry/pose.h>

namespace palpate {

/// Maximum number of joints of a chain: joint vectors and matrices have storage for as many in place, so that
/// `kinematics` allocates nothing in a servo tick.
inline constexpr int kMaxJoints = 12;

/// One number per joint, in the order of the chain. Shape: [joints].
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, kMaxJoints, 1>;
/// Shape: [joints, joints].
using JointMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, kMaxJoints, kMaxJoints>;
/// Rows 0-2 linear, 3-5 angular. Shape: [6, joints].
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::DontAlign, 6, kMaxJoints>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// How a joint moves.
enum class JointType {
  kPrismatic,  ///< along its axis. Positions are in [m].
  kRevolute,   ///< about its axis. Positions are in [rad].
};

/// Limits of a joint. The unit [u] is [m] or [rad], by the joint's type; forces are [N] or [N m].
struct JointLimits {
  double lower = 0.0, upper = 0.0;  ///< of the position; lower < upper. Unit: [u].
  double velocity = 0.0;            ///< > 0. Unit: [u/s].
  double acceleration = 0.0;        ///< > 0. Unit: [u/s^2].
  /// Motor effort available for motion, in excess of gravity compensation. > 0. Unit: [N] or [N m].
  double effort = std::numeric_limits<double>::infinity();
};

/// A rigid body, in the frame of the joint that moves it.
struct LinkInertia {
  double mass = 0.0;                                 ///< Unit: [kg]. >= 0
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of mass. Unit: [m].
  Eigen::Matrix3d inertia =
      Eigen::Matrix3d::Zero();  ///< about the centre. Unit: [kg m^2]. Positive semidefinite.
};

/// A joint and the link that it moves. The frame of the link is that of the joint after its motion.
struct ChainJoint {
  std::string name;
  JointType type = JointType::kRevolute;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit norm, in the joint's frame
  Pose origin;                                      ///< of the joint, in the frame of the link before it
  JointLimits limits;
  double rest =
      0.0;  ///< preferred position, which redundant motion approaches; within the limits. Unit: [u].
  LinkInertia link;
};

/// An open chain without branches, from its base to its tool centre point (TCP):
///
///     X_BT(q) = prod_i [ origin_i motion_i(q_i) ] tip
///
/// with base B and TCP T. The base is the device's frame.
struct SerialChain {
  std::string name;
  std::vector<ChainJoint> joints;  ///< 1 to kMaxJoints
  Pose tip;                        ///< of the TCP, in the frame of the last link

  int size() const { return static_cast<int>(joints.size()); }
};

/// JointLimits::lower and so on of all joints. Shape: [joints].
struct ChainLimits {
  explicit ChainLimits(const SerialChain& chain);
  JointVector lower, upper, velocity, acceleration, effort, rest;
};

/// \throws Error, one line that names `where`, the joint and the first value that is out of range. \param
/// where prefix of messages: a file, and perhaps a line
void check_chain(const SerialChain& chain, const std::string& where);

/// Lowers the acceleration limits so that no motor exceeds its effort, whatever the posture:
///
///     sum_j |M_ij| a_j <= effort_i        |M_ij| <= sum_k m_k r_ik r_jk + |I_k|
///
/// with M the joint-space inertia, r_ik the maximum distance of the mass of link k from the axis of joint i
/// (1 where that is prismatic). Velocity terms (dq^2) are neglected; the margin of the bound covers them.
/// \param payload additional mass at the TCP. Unit: [kg]. >= 0 \returns the factor in (0, 1] by which each
/// joint's limit was reduced. Shape: [joints].
JointVector limit_by_effort(SerialChain& chain, double payload);

}  // namespace palpate
