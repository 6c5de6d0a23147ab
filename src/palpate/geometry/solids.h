/// \file
/// Geometric queries on moving solid ellipsoids. World frame, or any other that all arguments share; lengths
/// in m.
#pragma once

#include <cmath>

#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// `solid` with its semi-axes lengthened by `margin`. \pre the semi-axes are positive
inline Ellipsoid enlarged(const Ellipsoid& solid, double margin) {
  Ellipsoid larger = solid;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double length = solid.axes.col(k).norm();
    larger.axes.col(k) *= (length + margin) / length;
  }
  return larger;
}

/// An ellipsoid that contains all points within `margin` of the solid; for a ball, exactly those. Any c > 0
/// gives valid semi-axes b_i^2 = (1 + 1/c) a_i^2 + (1 + c) margin^2. \pre the semi-axes and `margin` are
/// positive
inline Ellipsoid containing(const Ellipsoid& solid, double margin) {
  const Eigen::Array3d squared = solid.axes.colwise().squaredNorm().transpose().array();
  const double c = std::sqrt(std::sqrt(squared.minCoeff() * squared.maxCoeff())) / margin;
  const Eigen::Array3d larger = (1.0 + 1.0 / c) * squared + (1.0 + c) * margin * margin;
  return {solid.center, solid.axes * (larger / squared).sqrt().matrix().asDiagonal()};
}

/// Upper bound on the displacement of any point of a solid that moves from one place to the other.
inline double way_between(const Ellipsoid& from, const Ellipsoid& to) {
  return (to.center - from.center).norm() + (to.axes - from.axes).norm();
}

/// Image of a point of a solid that moves from one place to the other. \pre no semi-axis is zero
inline Eigen::Vector3d carried(const Ellipsoid& from, const Ellipsoid& to, const Eigen::Vector3d& point) {
  Eigen::Vector3d of_axes = from.axes.transpose() * (point - from.center);
  of_axes.array() /= from.axes.colwise().squaredNorm().transpose().array();
  return to.center + to.axes * of_axes;
}

/// The support point: the point of the solid that is farthest along `n`, of any length above zero.
inline Eigen::Vector3d farthest_point(const Ellipsoid& solid, const Eigen::Vector3d& n) {
  const Eigen::Vector3d seen = solid.axes.transpose() * n;
  return solid.center + solid.axes * (seen / seen.norm());
}

}  // namespace palpate
