/// \file
/// Ground truth that every pipeline is compared with.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/scene/scene_filter.h>

#include "pipeline.h"

namespace palpate::bench {

/// The contacts of each pose, ordered by id.
using Truth = std::vector<std::vector<Hit>>;

/// Computes the truth with a sweep over bounding spheres and the tests' oracle in long double, without the
/// library's tree, boxes or polynomial. The scene may be added in parts, so that it may be larger than
/// memory.
class TruthFinder {
 public:
  explicit TruthFinder(const std::vector<Ellipsoid>& tools);
  ~TruthFinder();

  /// Adds a part of the scene. Runs in parallel.
  void add(const EllipsoidScene& part);
  /// Returns the truth for all parts added. Call once, last.
  Truth take();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Deviation of the hits of all poses from the truth.
struct Accuracy {
  std::size_t misses = 0;
  std::size_t extras = 0;
  double worst_k = 0.0;       ///< largest |dK_min| of common hits; NaN for a pipeline without K
  double worst_missed = 0.0;  ///< largest true K_min of a miss: tells tangency from a gap

  /// Adds one pose. Sorts `found`.
  void add(const std::vector<Hit>& truth, std::vector<Hit>& found);
};

}  // namespace palpate::bench
