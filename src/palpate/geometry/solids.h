/// \file
/// What is asked of solid ellipsoids that move. World frame, or any other that all arguments share; lengths
/// in m.
#pragma once

#include <cmath>

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

/// One that contains all that is within `margin` of the solid; of a ball, just that. For every c > 0,
/// semi-axes b_i^2 = (1 + 1/c) a_i^2 + (1 + c) margin^2 do. \pre its semi-axes and `margin` are positive
inline Ellipsoid containing(const Ellipsoid& solid, double margin) {
  const Eigen::Array3d squared = solid.axes.colwise().squaredNorm().transpose().array();
  const double c = std::sqrt(std::sqrt(squared.minCoeff() * squared.maxCoeff())) / margin;
  const Eigen::Array3d larger = (1.0 + 1.0 / c) * squared + (1.0 + c) * margin * margin;
  return {solid.center, solid.axes * (larger / squared).sqrt().matrix().asDiagonal()};
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
