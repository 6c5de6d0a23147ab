/// \file
/// Interface of the compared contact queries, and their factories.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/collision/scene_index.h>
#include <palpate/geometry/ellipsoid.h>
#include <palpate/scene/scene_filter.h>

namespace palpate::bench {

/// A Gaussian that the tool overlaps.
struct Hit {
  std::uint32_t id;
  double k_min = std::numeric_limits<double>::quiet_NaN();  ///< NaN from a pipeline without K
};

/// A contact query on a built structure. One thread at a time.
class Pipeline {
 public:
  virtual ~Pipeline() = default;

  virtual std::string name() const = 0;

  /// Called before every pass over the poses. Not timed.
  virtual void prepare() {}

  /// Finds the Gaussians that `tool` overlaps. Timed.
  virtual void query(const Ellipsoid& tool) = 0;

  /// Returns the hits of the last query, in any order. Not timed.
  virtual void hits(std::vector<Hit>& out) const = 0;
};

/// Input of the build of pipelines. Each copies what its queries need, and keeps no reference to this.
struct PipelineInput {
  const GaussianScene& scene;  ///< for this library, which does its own filtering
  const SceneFilter& filter;
  const EllipsoidScene& ellipsoids;  ///< the filtered scene, for all others
  double search_radius;              ///< of the paper's kd-tree. Unit: [m].
  double complete_radius;            ///< least radius that reaches every contact. Unit: [m].
  bool every_target;                 ///< run this library on all instruction sets, not only the best
};

using Pipelines = std::vector<std::unique_ptr<Pipeline>>;

/// Pipelines that share one structure and its build.
struct Family {
  std::string_view name;  ///< on the command line
  Pipelines (*build)(const PipelineInput&);
  bool peer;  ///< true if not of this library
};

/// This library, then the peers.
std::span<const Family> families();

/// Family whose median is the reference for ratios.
inline constexpr std::string_view kPaper = "paper";

/// This library on an existing index: fresh queries on all SIMD targets, best first, or only on the best one;
/// and the tracker on the best.
Pipelines pipelines_of(const std::shared_ptr<const SceneIndex>& index, bool every_target);

/// The same, with a new index.
Pipelines build_palpate(const PipelineInput& input);
/// The paper's pipeline: nanoflann, bounding spheres, golden section.
Pipelines build_paper(const PipelineInput& input);
/// The same with the complete radius: the paper does not state its radius.
Pipelines build_complete_paper(const PipelineInput& input);
/// FCL: dynamic AABB tree, GJK of libccd.
Pipelines build_fcl(const PipelineInput& input);
/// Bullet: btDbvt, then as the paper.
Pipelines build_bullet(const PipelineInput& input);
/// Embree: point query, then as the paper.
Pipelines build_embree(const PipelineInput& input);

/// Family of one pipeline.
template <typename T, typename... Arguments>
Pipelines only(Arguments&&... arguments) {
  Pipelines pipelines;
  pipelines.push_back(std::make_unique<T>(std::forward<Arguments>(arguments)...));
  return pipelines;
}

}  // namespace palpate::bench
