/// \file
/// Rigid poses, twists and wrenches. SI units, right-handed frames, double precision.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/eigen_alignment.h>

namespace palpate {

/// Pose of a body B in the world W: p_W = orientation * p_B + position.
struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< Unit: [m], in the world frame.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< Unit norm, body to world.

  bool operator==(const Pose&) const = default;
};

/// The pose in the world of what has the pose `b` in the frame of a body at `a`.
inline Pose operator*(const Pose& a, const Pose& b) {
  return {a.orientation * b.position + a.position, a.orientation * b.orientation};
}

/// Velocity of a body: of its origin and about it, both expressed in the world frame.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< Unit: [m/s].
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< Unit: [rad/s].
};

/// What the tool *receives*: force in the world frame, torque about the tool centre in the world
/// frame. Pushing back is positive along the outward normal of the surface.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< Unit: [N].
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< Unit: [N m].
};

}  // namespace palpate
