/// \file
/// The Gaussians near a tool, as splatting draws them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <palpate/collision/index_layout.h>

namespace palpate {

/// Gaussians as a structure of arrays, along the axes of the world: centres in double precision, so that a
/// view may take them from wherever it is; the rest in single. Its size is fixed, so that refilling it takes
/// nothing from the heap.
struct LocalSplats {
  static constexpr std::size_t kCapacity = 4096;

  template <typename T>
  using Array = std::array<T, kCapacity + kIndexWidth>;  // so that whole vectors may be read at the end

  std::size_t size = 0;
  alignas(64) std::array<Array<double>, 3> center;  ///< world frame. Unit: [m].
  /// The rows of L, one after the other, with m^2 = |L (x - center)|^2: unit vectors along the semi-axes,
  /// over their lengths. Unit: [1/m].
  alignas(64) std::array<Array<float>, 9> whitening;
  alignas(64) Array<float> radius;   ///< the longest semi-axis. Unit: [m].
  alignas(64) Array<float> opacity;  ///< alpha in (0, 1]
  alignas(64) Array<std::uint32_t> id;

  /// A semi-axis counts as at least this share of the longest one: splats of no thickness are legal, and
  /// their whitening is not.
  static constexpr float kLeastThickness = 1e-3F;

  Eigen::Vector3d position(std::size_t i) const { return {center[0][i], center[1][i], center[2][i]}; }
};

struct CandidateSet;
struct CapturedFrame;

/// What find_magnified(..., times, `from`) found, as splatting draws it; what stands for others is larger for
/// it. Takes nothing from the heap.
/// \param frame of the index that it was found in
void fill_splats(const CandidateSet& from, const CapturedFrame& frame, float times, LocalSplats& result);

}  // namespace palpate
