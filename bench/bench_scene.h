/// \file
/// The scene of all benchmarks: flat Gaussians in any number, at a density independent of the number.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/scene/gaussian_scene.h>

#include "bench_shape.h"

namespace palpate::bench {

/// A row of an INRIA .ply without normals: the values as stored, neither activated nor normalised.
struct BenchGaussian {
  std::array<float, 3> position;
  std::array<float, 3> f_dc;  ///< the normal, as a colour
  float opacity;              ///< logit
  std::array<float, 3> scale;
  std::array<float, 4> rotation;
};
static_assert(sizeof(BenchGaussian) == 14 * sizeof(float), "written to files as it is");

/// A hall of square cells, each with its piece of floor and one object above it (a sphere, box, torus or
/// wall, randomly rotated). More Gaussians make more cells, not denser ones, so that the number of contacts
/// of a pose does not depend on the size of the scene. Immutable; safe for concurrent use.
///
/// Gaussian i is a pure function of (seed, i, n, spacing). Points are independent and uniform over the
/// surfaces; sigmas in the surface are log-normal about the spacing, those across it 10 to 50 times smaller;
/// one in a hundred Gaussians is 2 to 20 times larger, as in captures. Every opacity is above the
/// filter's default.
class BenchScene {
 public:
  static constexpr double kSpacing = 0.0035;  ///< Unit: [m].

  /// \param spacing one Gaussian per spacing^2 of surface. Unit: [m].
  explicit BenchScene(std::size_t n, std::uint64_t seed = 1, double spacing = kSpacing);

  std::size_t size() const { return size_; }
  std::size_t cells() const { return cells_.size(); }

  /// Height above which the scene is empty. Unit: [m].
  double height() const { return 2.0 * pitch_; }

  /// A point of uniform density on the surfaces of a cell. World frame. Unit: [m].
  SurfacePoint sample(std::size_t cell, HashRandom& random) const;

  BenchGaussian gaussian(std::size_t i) const;

  /// All Gaussians, without colours; ids are 0 ... n-1. Runs in parallel.
  GaussianScene load() const;

 private:
  struct Cell {
    Eigen::Vector3d center;  ///< of its floor
    Shape shape;
    Eigen::Quaterniond rotation;  ///< of the object
  };

  std::size_t size_;
  std::uint64_t seed_;
  double spacing_;
  double pitch_;  ///< side of a cell. Unit: [m].
  std::vector<Cell> cells_;
};

}  // namespace palpate::bench
