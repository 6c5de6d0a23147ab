/// \file
/// Rigid poses, twists and wrenches. SI units, right-handed frames, double precision.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/eigen_alignment.h>

namespace palpate {

/// X_FB, the pose of a body B in a frame F, which the variable's name or comment states: p_F = orientation *
/// p_B + position.
struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< Of the origin of B, in F. Unit: [m].
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< Unit norm, B to F.

  bool operator==(const Pose&) const = default;
};

/// X_FC = X_FB X_BC.
inline Pose operator*(const Pose& a, const Pose& b) {
  return {a.orientation * b.position + a.position, a.orientation * b.orientation};
}

/// V_FB, the velocity of a body B in a frame F: linear, of the origin of B, and angular, both expressed in F.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< Unit: [m/s].
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< Unit: [rad/s].
};

/// F_B_F, the wrench that a body B *receives*, expressed in a frame F; the torque is about the origin of B,
/// which is the handle of a tool. A repulsive force is positive along the outward normal of the surface.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< Unit: [N].
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< Unit: [N m].
};

}  // namespace palpate
