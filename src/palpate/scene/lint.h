/// \file
/// Statistics and defects of a scene.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Probabilities of Quantiles, taken over the sound Gaussians of a scene.
inline constexpr std::array<double, 7> kQuantiles{0.0, 0.01, 0.25, 0.5, 0.75, 0.99, 1.0};
using Quantiles = std::array<double, kQuantiles.size()>;

/// The opacity thresholds that the paper considers (III-A).
inline constexpr std::array<double, 3> kPaperThresholds{0.1, 0.2, 0.3};

/// Statistics of a scene in its captured frame; Gaussians with a defect count in `defects` only.
struct LintReport {
  std::size_t total = 0;
  std::array<std::size_t, kDefectCount> defects{};  ///< by Defect; [kNone] counts the sound ones
  /// Sound, but with a longest sigma above kGiantShare of the robust diagonal: felt as an invisible wall.
  /// Dropped only by SceneFilter::max_scale.
  std::size_t giant = 0;
  std::size_t flat = 0;               ///< sound, with one or two sigmas of zero: discs and needles
  double robust_diagonal = 0.0;       ///< diagonal of the box of the central 98 % of each coordinate
  Eigen::AlignedBox3d bounds;         ///< of the centres
  Eigen::AlignedBox3d robust_bounds;  ///< of the central 98 % of each coordinate
  /// Share of all Gaussians that are sound and of opacity above each of kPaperThresholds.
  std::array<double, kPaperThresholds.size()> share_above{};
  Quantiles opacity{};         ///< of alpha
  Quantiles longest_sigma{};   ///< captured units
  Quantiles shortest_sigma{};  ///< captured units
};

/// A Gaussian is giant if its longest sigma exceeds this share of the robust diagonal: at one sigma it then
/// spans a fifth of the scene, and no trained surface detail is that coarse.
inline constexpr double kGiantShare = 0.1;

LintReport lint(const GaussianScene& scene);

}  // namespace palpate
