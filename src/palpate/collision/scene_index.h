/// \file
/// Exact contact query over a scene.
#pragma once

#include <cstddef>
#include <memory>

#include <palpate/base/progress.h>
#include <palpate/collision/contact.h>
#include <palpate/collision/index_layout.h>
#include <palpate/collision/tool_frame.h>
#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// Owner of the memory of an index: arrays, or a mapped file.
class IndexStorage {
 public:
  virtual ~IndexStorage() = default;
  virtual IndexView view() const = 0;
};

/// A wide bounding volume hierarchy over the *ellipsoids*, not their centres, so that no Gaussian is missed
/// whatever its size, and a SIMD narrow phase whose verdicts do not depend on the instruction set (see
/// contact_kernel.h). It is stored in the captured frame, and tools are transformed into that, so that
/// re-registering the scene costs nothing. Copies share the memory and the epoch; every other construction,
/// including registered(), has an epoch of its own.
///
/// ContactSet::candidates counts the Gaussians in the blocks that the tool's box overlaps, and depends on the
/// tree; ContactSet::filtered those whose bounding spheres overlap the tool.
class SceneIndex final : public ContactQuery {
 public:
  /// Builds the index over the Gaussians of `scene` that `filter` keeps, in parallel on the calling thread's
  /// task arena; the result does not depend on the number of threads. If the filter keeps none, the index is
  /// valid and has no contacts.
  SceneIndex(const GaussianScene& scene, const SceneFilter& filter, const Similarity& world_from_scene,
             const Progress& progress = {});

  /// Uses existing memory.
  SceneIndex(std::shared_ptr<const IndexStorage> storage, const Similarity& world_from_scene);

  /// The same Gaussians under another registration.
  SceneIndex registered(const Similarity& world_from_scene) const { return {storage_, world_from_scene}; }

  /// Query in double precision. Allocates only if the contacts exceed the capacity of `result`.
  void query(const Ellipsoid& tool, ContactSet& result) const override;
  void query(const Ellipsoid& tool, Precision precision, ContactSet& result, QueryLimit limit = {}) const;

  const IndexView& view() const { return view_; }
  const Similarity& world_from_scene() const { return world_from_scene_; }
  /// True if both index the same Gaussians in the same memory, however registered.
  bool shares_memory_with(const SceneIndex& other) const { return storage_ == other.storage_; }
  /// Pose and scale of the captured frame in the world.
  const CapturedFrame& frame() const { return frame_; }

  /// Number of Gaussians in the index.
  std::size_t size() const { return view_.gaussians; }

  /// The median of Contact::extent over a sample of the Gaussians; 0 if there are none. Reads at most a
  /// megabyte of the index. Unit: [m].
  double usual_extent() const;

  /// Bytes of memory, or of the file, that the index takes.
  std::size_t bytes() const;

 private:
  std::shared_ptr<const IndexStorage> storage_;
  IndexView view_;
  Similarity world_from_scene_;
  CapturedFrame frame_;
};

}  // namespace palpate
