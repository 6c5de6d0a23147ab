#include "bench_scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include <palpate/geometry/rotation.h>

namespace palpate::bench {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::size_t kGaussiansPerCell = 40'000;
constexpr double kObjectArea = 0.8;  // area of an object relative to its cell's floor
constexpr double kObjectHeight =
    0.55;  // of its centre above the floor, in sides of a cell: clear of other objects
constexpr double kSizeSpread = 0.35;  // standard deviation of ln sigma in the surface
constexpr double kOffset = 0.1;       // standard deviation along the normal, in spacings
constexpr double kTilt = 0.05;        // standard deviation of each component of the tilt. Unit: [rad].
constexpr double kLargeShare = 0.01;

double in_plane_sigma(double typical, HashRandom& random) {
  return typical * std::exp(kSizeSpread * random.normal());
}

Vector3d random_sigma(double spacing, HashRandom& random) {
  const double large = random.uniform() < kLargeShare ? random.log_uniform(2.0, 20.0) : 1.0;
  const double u = in_plane_sigma(large * spacing, random);
  const double v = in_plane_sigma(large * spacing, random);
  return {u, v, std::sqrt(u * v) / random.log_uniform(10.0, 50.0)};
}

/// Random rotation that maps z close to `normal`.
Quaterniond random_frame(const Vector3d& normal, HashRandom& random) {
  const double z = random.normal(), y = random.normal(), x = random.normal();
  const Vector3d tilt = kTilt * Vector3d(x, y, z);
  const Eigen::AngleAxisd roll(random.uniform(0.0, 2.0 * std::numbers::pi), Vector3d::UnitZ());
  return rotation_between(Vector3d::UnitZ(), normal + tilt) * roll;
}

std::array<float, 3> to_floats(const Vector3d& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

double logit(double p) { return std::log(p / (1.0 - p)); }

}  // namespace

BenchScene::BenchScene(std::size_t n, std::uint64_t seed, double spacing)
    : size_(n), seed_(seed), spacing_(spacing), cells_(std::max<std::size_t>(1, n / kGaussiansPerCell)) {
  // The remainder of the division makes all cells slightly larger, rather than one of them emptier.
  const double area = static_cast<double>(n) / static_cast<double>(cells_.size()) * spacing * spacing;
  pitch_ = std::sqrt(area / (1.0 + kObjectArea));
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(cells_.size()))));
  const double first = -0.5 * static_cast<double>(side - 1);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    HashRandom random(seed, Purpose::kCell, i);
    const std::size_t column = i % side, row = i / side;
    const Vector3d place(first + static_cast<double>(column), first + static_cast<double>(row), 0.0);
    cells_[i] = {pitch_ * place, static_cast<Shape>(random.index(kShapeCount)), random_rotation(random)};
  }
}

SurfacePoint BenchScene::sample(std::size_t cell, HashRandom& random) const {
  const auto& [center, shape, rotation] = cells_[cell];
  if (random.uniform(0.0, 1.0 + kObjectArea) < 1.0) {
    const double y = random.uniform(-0.5, 0.5), x = random.uniform(-0.5, 0.5);
    const Vector3d across(x, y, 0.0);
    return {center + pitch_ * across, Vector3d::UnitZ()};
  }
  const auto [point, normal] = sample_unit_area(shape, random);
  const Vector3d raised = center + Vector3d(0.0, 0.0, kObjectHeight * pitch_);
  return {raised + rotation * point * (std::sqrt(kObjectArea) * pitch_), rotation * normal};
}

BenchGaussian BenchScene::gaussian(std::size_t i) const {
  HashRandom random(seed_, Purpose::kGaussian, i);
  const auto [point, normal] = sample(i % cells_.size(), random);
  const Vector3d sigma = random_sigma(spacing_, random);
  const Quaterniond q = random_frame(normal, random);
  const double norm = random.uniform(0.5, 2.0);  // training does not keep quaternions at length 1

  BenchGaussian g;
  g.position = to_floats(point + kOffset * spacing_ * random.normal() * normal);
  g.f_dc = to_floats(normal);
  g.opacity = static_cast<float>(logit(random.uniform(0.12, 0.99)));
  g.scale = to_floats(sigma.array().log());
  g.rotation = {static_cast<float>(norm * q.w()), static_cast<float>(norm * q.x()),
                static_cast<float>(norm * q.y()), static_cast<float>(norm * q.z())};
  return g;
}

GaussianScene BenchScene::load() const {
  GaussianScene scene;
  scene.source = "benchmark scene";
  scene.id.resize(size_);
  std::iota(scene.id.begin(), scene.id.end(), 0U);
  scene.position.resize(size_);
  scene.scale.resize(size_);
  scene.rotation.resize(size_);
  scene.opacity.resize(size_);
  tbb::parallel_for(std::size_t{0}, size_, [&](std::size_t i) {
    const BenchGaussian g = gaussian(i);
    scene.position[i] = Eigen::Vector3f(g.position.data());
    scene.scale[i] = Eigen::Vector3f(g.scale.data());
    scene.rotation[i] = Eigen::Vector4f(g.rotation.data());
    scene.opacity[i] = g.opacity;
  });
  return scene;
}

}  // namespace palpate::bench
