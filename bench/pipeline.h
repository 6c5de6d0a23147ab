/// \file
/// What is compared: a contact query behind one small interface, and how each is made.
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
  double k_min = std::numeric_limits<double>::quiet_NaN();  ///< NaN from a pipeline that only says yes or no
};

/// A contact query, built. One thread at a time.
class Pipeline {
 public:
  virtual ~Pipeline() = default;

  virtual std::string name() const = 0;

  /// Before every pass over the poses. Not timed.
  virtual void prepare() {}

  /// Finds what `tool` touches. Timed.
  virtual void query(const Ellipsoid& tool) = 0;

  /// What the last query found, in any order. Not timed.
  virtual void hits(std::vector<Hit>& out) const = 0;
};

/// What pipelines are built from. Each keeps a copy of all that its queries need, and nothing of this.
struct PipelineInput {
  const GaussianScene& scene;  ///< for this library, which filters for itself
  const SceneFilter& filter;
  const EllipsoidScene& ellipsoids;  ///< the same filtered, for all others
  double search_radius;              ///< of the paper's kd-tree. Unit: [m].
  double complete_radius;            ///< the least with which no contact is out of its reach. Unit: [m].
  bool every_target;                 ///< this library on all instruction sets, not only the best
};

using Pipelines = std::vector<std::unique_ptr<Pipeline>>;

/// Pipelines that share one structure, and so one build.
struct Family {
  std::string_view name;  ///< on the command line
  Pipelines (*build)(const PipelineInput&);
  bool peer;  ///< not of this library
};

/// This library, then the peers.
std::span<const Family> families();

/// The family whose median others are set against.
inline constexpr std::string_view kPaper = "paper";

/// This library on an index that is there: fresh on SIMD targets, best first or only the best, and tracking
/// on the best.
Pipelines pipelines_of(const std::shared_ptr<const SceneIndex>& index, bool every_target);

/// The same, and the index too.
Pipelines build_palpate(const PipelineInput& input);
/// The paper's pipeline: nanoflann, bounding spheres, golden section.
Pipelines build_paper(const PipelineInput& input);
/// The same with the complete radius: the paper does not give its own.
Pipelines build_complete_paper(const PipelineInput& input);
/// FCL: dynamic AABB tree, GJK of libccd.
Pipelines build_fcl(const PipelineInput& input);
/// Bullet: btDbvt, then as the paper.
Pipelines build_bullet(const PipelineInput& input);
/// Embree: point query, then as the paper.
Pipelines build_embree(const PipelineInput& input);

/// A family of one.
template <typename T, typename... Arguments>
Pipelines only(Arguments&&... arguments) {
  Pipelines pipelines;
  pipelines.push_back(std::make_unique<T>(std::forward<Arguments>(arguments)...));
  return pipelines;
}

}  // namespace palpate::bench
