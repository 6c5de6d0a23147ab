#include "bench_shape.h"

#include <cmath>
#include <numbers>

namespace palpate::bench {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

SurfacePoint sample_sphere(HashRandom& random) {
  const double radius = std::sqrt(1.0 / (4.0 * pi));
  const double z = random.uniform(-1.0, 1.0);  // Archimedes: equal heights, equal areas
  const double angle = random.uniform(0.0, 2.0 * pi);
  const double rho = std::sqrt(1.0 - z * z);
  const Vector3d normal(rho * std::cos(angle), rho * std::sin(angle), z);
  return {radius * normal, normal};
}

SurfacePoint sample_box(const Vector3d& proportions, HashRandom& random) {
  const Vector3d faces(proportions[1] * proportions[2], proportions[2] * proportions[0],
                       proportions[0] * proportions[1]);
  const Vector3d half = proportions * (0.5 / std::sqrt(2.0 * faces.sum()));
  double pick = random.uniform(0.0, 2.0 * faces.sum());
  int axis = 0;
  while (axis < 2 && pick >= 2.0 * faces[axis]) pick -= 2.0 * faces[axis++];
  const double side = pick < faces[axis] ? -1.0 : 1.0;
  const double z = random.uniform(-1.0, 1.0), y = random.uniform(-1.0, 1.0), x = random.uniform(-1.0, 1.0);
  Vector3d point(x, y, z);
  point[axis] = side;
  return {point.cwiseProduct(half), side * Vector3d::Unit(axis)};
}

SurfacePoint sample_torus(HashRandom& random) {
  constexpr double kTube = 0.4;  // minor radius over major radius
  const double major = std::sqrt(1.0 / (4.0 * pi * pi * kTube));
  double tube_angle = 0.0;
  do {  // the outer side of the tube has more area than the inner one
    tube_angle = random.uniform(0.0, 2.0 * pi);
  } while (random.uniform(0.0, 1.0 + kTube) > 1.0 + kTube * std::cos(tube_angle));
  const double angle = random.uniform(0.0, 2.0 * pi);
  const Vector3d outwards(std::cos(angle), std::sin(angle), 0.0);
  const Vector3d normal = std::cos(tube_angle) * outwards + std::sin(tube_angle) * Vector3d::UnitZ();
  return {major * (outwards + kTube * normal), normal};
}

}  // namespace

SurfacePoint sample_unit_area(Shape shape, HashRandom& random) {
  switch (shape) {
    case Shape::kSphere: return sample_sphere(random);
    case Shape::kBox: return sample_box({1.0, 0.7, 0.5}, random);
    case Shape::kTorus: return sample_torus(random);
    case Shape::kWall: break;
  }
  return sample_box({0.8, 0.5, 0.03}, random);
}

Eigen::Quaterniond random_rotation(HashRandom& random) {
  const double w = random.normal(), x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Quaterniond(w, x, y, z).normalized();
}

}  // namespace palpate::bench
