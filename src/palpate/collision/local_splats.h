/// \file
/// The Gaussians near a tool, as splatting draws them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <palpate/base/aligned_vector.h>
#include <palpate/collision/index_layout.h>
#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// Gaussians as a structure of arrays, along the axes of the world: centres in double precision, so that a
/// view may take them from wherever it is; the rest in single. Its capacity is fixed when it is made, so that
/// refilling it takes nothing from the heap.
struct LocalSplats {
  static constexpr std::size_t kCapacity = 4096;  ///< at most

  explicit LocalSplats(std::size_t capacity = kCapacity);

  template <typename T>
  using Array =
      AlignedVector<T>;  // of the capacity and kIndexWidth, that whole vectors may be read at the end

  std::size_t size = 0;
  std::array<Array<double>, 3> center;  ///< world frame. Unit: [m].
  /// The rows of L, one after the other, with m^2 = |L (x - center)|^2: unit vectors along the semi-axes,
  /// over their lengths. Unit: [1/m].
  std::array<Array<float>, 9> whitening;
  Array<float> radius;   ///< the longest semi-axis. Unit: [m].
  Array<float> opacity;  ///< alpha in (0, 1]
  Array<std::uint32_t> id;

  /// A semi-axis counts as at least this share of the longest one: splats of no thickness are legal, and
  /// their whitening is not.
  static constexpr float kLeastThickness = 1e-3F;

  Eigen::Vector3d position(std::size_t i) const { return {center[0][i], center[1][i], center[2][i]}; }
};

/// Replaces `result` by those of `splats` that may reach into `solid`, in their order: all that do, and a few
/// besides. Takes nothing from the heap. \param solid world frame \returns false if they do not fit its
/// capacity; it is then empty
bool select_splats(const LocalSplats& splats, const Ellipsoid& solid, LocalSplats& result);

struct CandidateSet;
struct CapturedFrame;

/// What find_magnified(..., times, `from`) found, as splatting draws it; what stands for others is larger for
/// it. Takes nothing from the heap. \pre `result` has the capacity of `from`
/// \param frame of the index that it was found in
void fill_splats(const CandidateSet& from, const CapturedFrame& frame, float times, LocalSplats& result);

}  // namespace palpate
