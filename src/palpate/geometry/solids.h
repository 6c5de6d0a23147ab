/// \file
/// What is asked of solid ellipsoids that move. World frame, or any other that all arguments share; lengths
/// in m.
#pragma once

#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// With semi-axes longer by `margin`. \pre they are positive
inline Ellipsoid enlarged(const Ellipsoid& solid, double margin) {
  Ellipsoid larger = solid;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double length = solid.axes.col(k).norm();
    larger.axes.col(k) *= (length + margin) / length;
  }
  return larger;
}

/// How far a point of a solid moves from one place to the other, at most.
inline double way_between(const Ellipsoid& from, const Ellipsoid& to) {
  return (to.center - from.center).norm() + (to.axes - from.axes).norm();
}

/// Where a point of a solid goes that moves from one place to the other. \pre no semi-axis is zero
inline Eigen::Vector3d carried(const Ellipsoid& from, const Ellipsoid& to, const Eigen::Vector3d& point) {
  Eigen::Vector3d of_axes = from.axes.transpose() * (point - from.center);
  of_axes.array() /= from.axes.colwise().squaredNorm().transpose().array();
  return to.center + to.axes * of_axes;
}

/// The point of the solid that is farthest along `n`, of any length above zero.
inline Eigen::Vector3d farthest_point(const Ellipsoid& solid, const Eigen::Vector3d& n) {
  const Eigen::Vector3d seen = solid.axes.transpose() * n;
  return solid.center + solid.axes * (seen / seen.norm());
}

}  // namespace palpate
