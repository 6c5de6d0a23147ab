/// \file
/// What every pipeline is held to.
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

/// Finds the truth from a sweep over bounding spheres and the oracle of the tests in long double: neither
/// tree, nor boxes, nor polynomial of the library. The scene may come in parts, so that it may be larger than
/// memory.
class TruthFinder {
 public:
  explicit TruthFinder(const std::vector<Ellipsoid>& tools);
  ~TruthFinder();

  /// Some of the scene. Runs in parallel.
  void add(const EllipsoidScene& part);
  /// The truth about all that was added. Call once, last.
  Truth take();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// How the hits of all poses differ from the truth.
struct Accuracy {
  std::size_t misses = 0;
  std::size_t extras = 0;
  double worst_k = 0.0;       ///< |dK_min| over what both found; NaN from a pipeline that has no K
  double worst_missed = 0.0;  ///< the largest true K_min of a miss: tangency, or a hole?

  /// Adds one pose. `found` is sorted.
  void add(const std::vector<Hit>& truth, std::vector<Hit>& found);
};

}  // namespace palpate::bench
