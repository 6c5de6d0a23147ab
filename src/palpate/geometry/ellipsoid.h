/// \file
/// Solid ellipsoids: the collision geometry of Gaussians and tools.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/pose.h>

namespace palpate {

/// The solid { center + axes * u : |u| <= 1 }. Both members are in one frame, usually the world.
/// The covariance of the paper is axes * axes^T; it is never formed, because its inverse is
/// useless for flat Gaussians. A semi-axis may be zero (a disc or a needle is legal).
struct Ellipsoid {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< Unit: [m].
  /// Columns are the semi-axis vectors, mutually orthogonal. Unit: [m].
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();

  /// From semi-axis lengths in [m] along the body axes of `pose`.
  static Ellipsoid from_semi_axes(const Pose& pose, const Eigen::Vector3d& semi_axes) {
    return {pose.position, pose.orientation.toRotationMatrix() * semi_axes.asDiagonal()};
  }

  /// Half the extent along the unit vector `n`: the support function h(n) = |axes^T n|. Unit: [m].
  double support(const Eigen::Vector3d& n) const { return (axes.transpose() * n).norm(); }

  /// Half the extents along the frame's axes: the tight bounding box is center -/+ this.
  Eigen::Vector3d half_extents() const { return axes.rowwise().norm(); }

  /// Longest semi-axis, the radius of the tight bounding sphere. Unit: [m].
  double radius() const { return axes.colwise().norm().maxCoeff(); }
};

}  // namespace palpate
