/// \file
/// Solids, and pairs of them, made by hand.
#pragma once

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>

namespace palpate::test {

/// One whose axes are those of the world.
inline Ellipsoid ellipsoid(const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes) {
  return {center, semi_axes.asDiagonal()};
}
inline Ellipsoid ball(const Eigen::Vector3d& center, double radius) {
  return ellipsoid(center, Eigen::Vector3d::Constant(radius));
}

/// What the overlap test is about.
struct Pair {
  Ellipsoid tool, gaussian;
};

}  // namespace palpate::test
