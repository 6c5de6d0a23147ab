/// \file
/// The objects of the benchmark scene.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "hash_random.h"

namespace palpate::bench {

/// A point of a surface, and the outward unit normal there.
struct SurfacePoint {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
};

enum class Shape { kSphere, kBox, kTorus, kWall };
inline constexpr std::size_t kShapeCount = 4;

/// A point of uniform density on the shape of area 1 about the origin. All shapes fit into a sphere of radius
/// 0.52.
SurfacePoint sample_unit_area(Shape shape, HashRandom& random);

/// Uniform over all rotations.
Eigen::Quaterniond random_rotation(HashRandom& random);

}  // namespace palpate::bench
