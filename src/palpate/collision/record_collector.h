/// \file
/// Collects the records that an index is built over.
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include <palpate/collision/index_builder.h>
#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// Collects the Gaussians that a filter keeps, from consecutive parts of a scene.
class RecordCollector {
 public:
  RecordCollector(const SceneFilter& filter, const Similarity& world_from_scene)
      : filter_(filter), world_from_scene_(world_from_scene) {}

  /// Appends the Gaussians of `scene` that the filter keeps. In parallel on the calling thread's task arena;
  /// the result does not depend on the number of threads.
  void add(const GaussianScene& scene);

  /// Reserves capacity for `n` Gaussians.
  void reserve(std::size_t n) { records_.reserve(n); }
  /// Removes the records, not the report.
  void clear() { records_.clear(); }

  const std::vector<GaussianRecord>& records() const { return records_; }
  const FilterReport& report() const { return report_; }

 private:
  SceneFilter filter_;
  Similarity world_from_scene_;
  std::vector<GaussianRecord> records_;
  FilterReport report_;
};

/// The bounding boxes of `records`.
std::vector<Eigen::AlignedBox3f> boxes_of(std::span<const GaussianRecord> records);

}  // namespace palpate
