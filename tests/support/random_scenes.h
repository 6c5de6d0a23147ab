/// \file
/// Random scenes and tools for the tests of the contact queries.
#pragma once

#include <cstddef>
#include <vector>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/geometry/rotation.h>
#include <support/random_pairs.h>
#include <support/splats.h>

namespace palpate::test {

/// Semi-axes over nine orders of magnitude, some of them zero.
inline Eigen::Vector3d wild_semi_axes(Random& r) {
  const double size = r.log_uniform(1e-6, 1e3);
  Eigen::Vector3d s = size * r.semi_axes(1e-3, 1.0);
  if (r.integer(0, 9) == 0) s[r.integer(0, 2)] = 0.0;
  return s;
}

inline Splat wild_splat(Random& r, double half) {
  const Eigen::Vector3d position = r.in_box(half);
  const Eigen::Quaterniond q = r.rotation();
  const Eigen::Vector3d semi_axes = wild_semi_axes(r);
  return splat(position, semi_axes, q, r.uniform(0.2, 0.99));
}

/// A cloud like a captured scene: small flat splats near the unit sphere.
inline std::vector<Splat> sphere_of_splats(Random& r, std::size_t count) {
  std::vector<Splat> result;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d n = r.direction();
    const Eigen::Quaterniond q =
        rotation_between(Eigen::Vector3d::UnitZ(), (n + 0.1 * r.direction()).normalized());
    const Eigen::Vector3d center = n * (1.0 + 0.005 * r.normal());
    const double a = r.log_uniform(0.003, 0.05), b = r.log_uniform(0.003, 0.05);
    const double thickness = r.log_uniform(1e-6, 1e-3);
    result.push_back(splat(center, {a, b, thickness}, q, r.uniform(0.15, 0.99)));
  }
  return result;
}

inline std::vector<Ellipsoid> random_tools(Random& r, std::size_t count, double half, double low,
                                           double high) {
  std::vector<Ellipsoid> tools;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose pose{r.in_box(half), r.rotation()};
    const double size = r.log_uniform(low, high);
    tools.push_back(Ellipsoid::from_semi_axes(pose, size * r.semi_axes(0.3, 1.0)));
  }
  return tools;
}

/// Tools of the default size that all but touch the unit sphere.
inline std::vector<Ellipsoid> tools_at_sphere(Random& r, std::size_t count) {
  std::vector<Ellipsoid> tools;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose pose{r.vector(0.97, 1.03), r.rotation()};
    tools.push_back(Ellipsoid::from_semi_axes(pose, {0.02, 0.02, 0.04}));
  }
  return tools;
}

}  // namespace palpate::test
