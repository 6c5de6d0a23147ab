#include "bench_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace palpate::bench {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kPosesPerStroke = 125;
constexpr double kShortest = 0.015, kLongest = 0.04;     // length of a stroke. Unit: [m].
constexpr double kMaxSpin = 0.3;                         // Unit: [rad].
constexpr double kLeastPush = 0.35, kDeepestPush = 0.8;  // in shortest semi-axes of the tool
constexpr double kGap = 0.2;                             // clearance at both ends, likewise

/// End point of a stroke, by rejection sampling: same side of the same surface, within the length limits.
SurfacePoint sample_near(const SurfacePoint& from, const BenchScene& scene, std::size_t cell,
                         HashRandom& random) {
  constexpr int kTrials = 10'000;
  for (int i = 0; i < kTrials; ++i) {
    SurfacePoint to = scene.sample(cell, random);
    const double distance = (to.point - from.point).norm();
    if (distance > kShortest && distance < kLongest && to.normal.dot(from.normal) > 0.5) return to;
  }
  return from;  // scene too small for a slide
}

template <typename T>
void shuffle(std::vector<T>& values, HashRandom random) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random.index(i)]);
}

}  // namespace

Stroke::Stroke(const BenchScene& scene, const Vector3d& tool, HashRandom& random) : tool_(tool) {
  const std::size_t cell = random.index(scene.cells());
  from_ = scene.sample(cell, random);
  to_ = sample_near(from_, scene, cell, random);
  orientation_ = random_rotation(random);
  spin_axis_ = random_rotation(random) * Vector3d::UnitX();
  spin_ = random.uniform(0.0, kMaxSpin);
  push_ = tool.minCoeff() * random.uniform(kLeastPush, kDeepestPush);
}

Ellipsoid Stroke::at(double s) const {
  const double gap = kGap * tool_.minCoeff();
  const double wave = std::sin(std::numbers::pi * s);
  return at_depth(s, (push_ + gap) * wave * wave - gap);
}

Ellipsoid Stroke::at_depth(double s, double depth) const {
  const Vector3d normal = ((1.0 - s) * from_.normal + s * to_.normal).normalized();
  const Eigen::Quaterniond orientation = Eigen::AngleAxisd(s * spin_, spin_axis_) * orientation_;
  Ellipsoid tool = Ellipsoid::from_semi_axes({Vector3d::Zero(), orientation}, tool_);
  tool.center = (1.0 - s) * from_.point + s * to_.point + (tool.support(normal) - depth) * normal;
  return tool;
}

std::vector<Ellipsoid> make_poses(const BenchScene& scene, const PoseOptions& options) {
  std::vector<Ellipsoid> poses;
  poses.reserve(options.count);
  const std::size_t per_stroke = options.whole_scene ? 1 : kPosesPerStroke;
  for (std::size_t stroke = 0; poses.size() < options.count; ++stroke) {
    HashRandom random(options.seed, Purpose::kPose, stroke);
    const Stroke touch(scene, options.tool, random);
    const std::size_t end = std::min(options.count, poses.size() + per_stroke);
    for (std::size_t i = 0; poses.size() < end; ++i) {
      const double s = options.whole_scene ? random.uniform()
                                           : (static_cast<double>(i) + 0.5) / static_cast<double>(per_stroke);
      poses.push_back(touch.at(s));
    }
  }
  if (options.shuffle) shuffle(poses, HashRandom(options.seed, Purpose::kOrder, 0));
  return poses;
}

}  // namespace palpate::bench
