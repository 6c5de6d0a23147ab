/// \file
/// Gaussians near a tool, in the form that splatting draws.
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
/// renderer may subtract any viewpoint; the rest in single. The capacity is fixed at construction, so that
/// refilling allocates nothing.
struct LocalSplats {
  static constexpr std::size_t kCapacity = 4096;  ///< at most

  explicit LocalSplats(std::size_t capacity = kCapacity);

  template <typename T>
  using Array =
      AlignedVector<T>;  // of the capacity and kIndexWidth, that whole vectors may be read at the end

  std::size_t size = 0;
  std::array<Array<double>, 3> center;  ///< world frame. Unit: [m].
  /// The rows of L, consecutively, with m^2 = |L (x - center)|^2: unit vectors along the semi-axes, divided
  /// by their lengths. Unit: [1/m].
  std::array<Array<float>, 9> whitening;
  Array<float> radius;   ///< the longest semi-axis. Unit: [m].
  Array<float> opacity;  ///< alpha in (0, 1]
  Array<std::uint32_t> id;

  /// Minimum semi-axis relative to the longest one, used for the whitening: a Gaussian of zero thickness is
  /// legal, but its whitening is singular.
  static constexpr float kLeastThickness = 1e-3F;

  Eigen::Vector3d position(std::size_t i) const { return {center[0][i], center[1][i], center[2][i]}; }
};

/// Replaces `result` by those of `splats` that may reach into `solid`, in their order: all that do, and a few
/// more. No heap allocation. \param solid world frame \returns false if they exceed its capacity; it is then
/// empty
bool select_splats(const LocalSplats& splats, const Ellipsoid& solid, LocalSplats& result);

struct CandidateSet;
struct CapturedFrame;

/// Converts the result of find_magnified(..., times, `from`) to splats; samples that represent others are
/// enlarged accordingly. No heap allocation. \pre `result` has the capacity of `from` \param frame of the
/// index that was searched
void fill_splats(const CandidateSet& from, const CapturedFrame& frame, float times, LocalSplats& result);

}  // namespace palpate
