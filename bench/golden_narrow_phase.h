/// \file
/// The paper's narrow phase, for libraries that provide only a broad phase.
#pragma once

#include <cstdint>
#include <vector>

#include <palpate/collision/k_function.h>
#include <palpate/scene/scene_filter.h>

#include "pipeline.h"

namespace palpate::bench {

/// Narrow phase of the paper: bounding spheres (eq. 4), then golden-section search with as many iterations as
/// PaperPipeline on the same KFunction. A test of bounding boxes is added in between: a broad phase that
/// compares with the tool's sphere alone would otherwise cost golden sections that any collision library
/// avoids.
class GoldenNarrowPhase {
 public:
  explicit GoldenNarrowPhase(const EllipsoidScene& scene);

  const std::vector<Ellipsoid>& ellipsoids() const { return ellipsoids_; }
  const std::vector<Hit>& hits() const { return hits_; }

  /// One query, which tests the candidates of the broad phase.
  class Query {
   public:
    Query(GoldenNarrowPhase& phase, const Ellipsoid& tool);
    void test(std::size_t i);

   private:
    GoldenNarrowPhase& phase_;
    WhitenedTool tool_;
    double tool_radius_;
    Eigen::Vector3d tool_half_;
  };

 private:
  std::vector<Ellipsoid> ellipsoids_;
  std::vector<double> radius_;
  std::vector<std::uint32_t> id_;
  std::vector<Hit> hits_;
};

}  // namespace palpate::bench
