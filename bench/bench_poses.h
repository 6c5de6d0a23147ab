/// \file
/// Tool poses in the benchmark scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/geometry/ellipsoid.h>

#include "bench_scene.h"

namespace palpate::bench {

/// The tool of all benchmarks. Semi-axes. Unit: [m].
inline const Eigen::Vector3d kTool{0.02, 0.02, 0.04};

struct PoseOptions {
  std::size_t count = 5000;
  std::uint64_t seed = 1;
  Eigen::Vector3d tool = kTool;
  bool shuffle = false;      ///< the same poses in random order: no pose is near the one before
  bool whole_scene = false;  ///< every pose at a random place, so that caches are cold for every pipeline
};

/// A contact of an eighth of a second: the tool approaches a surface, slides along it for a few centimetres,
/// deepest half way, while rotating slowly, and leaves it again.
class Stroke {
 public:
  /// Draws a stroke at a random place of the scene.
  Stroke(const BenchScene& scene, const Eigen::Vector3d& tool, HashRandom& random);

  /// Tool at fraction `s` in [0, 1] of the stroke.
  Ellipsoid at(double s) const;

  /// The same place and orientation with the tool's lowest point `depth` below the surface; negative is
  /// above. Unit: [m].
  Ellipsoid at_depth(double s, double depth) const;

 private:
  Eigen::Vector3d tool_;  ///< semi-axes. Unit: [m].
  SurfacePoint from_, to_;
  Eigen::Quaterniond orientation_;  ///< at s = 0
  Eigen::Vector3d spin_axis_;       ///< unit
  double spin_;                     ///< rotation over the stroke. Unit: [rad].
  double push_;                     ///< depth at s = 0.5. Unit: [m].
};

/// Poses of consecutive strokes, sampled at 1 kHz unless the options say otherwise.
std::vector<Ellipsoid> make_poses(const BenchScene& scene, const PoseOptions& options);

}  // namespace palpate::bench
