/// \file
/// The exact contact query: a bounding volume hierarchy over ellipsoids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/contact.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// A binary hierarchy of axis-aligned boxes over the *ellipsoids*, not their centres, so that no
/// Gaussian is missed whatever its size. A query walks the boxes that meet the tool's box, drops
/// what the bounding spheres separate (paper eq. 4), and minimises K for the rest.
///
/// ContactSet::candidates counts the Gaussians whose own box meets the tool's box, which no
/// arrangement of the tree can change.
class SceneIndex final : public ContactQuery {
 public:
  /// Builds in parallel on the calling thread's task arena; the result is the same on any number
  /// of threads. Time O(n log n). An empty scene is legal and is never touched.
  explicit SceneIndex(EllipsoidScene scene, const Progress& progress = {});

  void query(const Ellipsoid& tool, ContactSet& result) const override;

  /// The Gaussians, in the order of the leaves.
  const EllipsoidScene& scene() const { return scene_; }

  /// Bytes of memory held.
  std::size_t bytes() const;

 private:
  /// A box in single precision, rounded outwards, over a run of Gaussians. The left child of an
  /// inner node is the next node.
  struct Node {
    float low[3];
    float high[3];
    std::uint32_t right;  ///< inner: distance to the right child; leaf: first Gaussian
    std::uint32_t count;  ///< inner: 0; leaf: number of Gaussians
  };
  static_assert(sizeof(Node) == 32, "two nodes a cache line");

  class Builder;

  EllipsoidScene scene_;
  std::vector<Node> nodes_;
};

}  // namespace palpate
