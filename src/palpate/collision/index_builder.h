/// \file
/// Builder of the bounding volume hierarchy of a SceneIndex.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/collision/index_layout.h>

namespace palpate {

/// A Gaussian to be stored in a block, see GaussianBlock.
struct GaussianRecord {
  std::array<float, 3> position;  ///< relative to the origin
  std::array<float, 3> length_high, length_low;
  std::array<float, 4> rotation;
  float opacity_high, opacity_low;
  std::uint32_t id;
};
static_assert(sizeof(GaussianRecord) == 64, "what a spilled build writes");

/// Maximum number of records of one tree; larger scenes are built in parts. Bounds the memory of a build.
inline constexpr std::size_t kMaxTreeRecords = std::size_t{1} << 23;

/// A tree over part of a scene, or all of it.
struct IndexTree {
  std::vector<IndexNode> nodes;  ///< the root first; children are indices into this and into `blocks`
  std::vector<GaussianBlock> blocks;
  Eigen::AlignedBox3f box;  ///< of all records
};

/// The single-precision box of a Gaussian, rounded outwards: it contains { position + axes u : |u| <= 1 },
/// whose half extents along the frame's axes are `half`.
Eigen::AlignedBox3f outer_box(const Eigen::Vector3f& position, const Eigen::Vector3d& half);

/// Builds a tree over `records`, whose boxes are `boxes`, by the surface area heuristic over binned box
/// centres (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), sixteen ways at a
/// time and with full blocks: splits are moved to the next multiple of sixteen. Runs on the calling thread's
/// task arena; the result does not depend on the number of threads. Time O(n log n). \pre 1 to
/// kMaxTreeRecords records.
IndexTree build_tree(std::span<const GaussianRecord> records, std::span<const Eigen::AlignedBox3f> boxes);

/// Joins the trees of the parts of a scene into one.
class IndexForest {
 public:
  /// Adds a tree and returns its blocks, which follow those of earlier trees in the order of the leaves and
  /// need not be kept in memory. Trees that are neighbours in space should be added consecutively. \throws
  /// Error if there are more than kMaxIndexBlocks.
  std::vector<GaussianBlock> plant(IndexTree tree);

  /// Moves out the nodes of all trees, under one root, which is the first.
  std::vector<IndexNode> join();

 private:
  struct Root {
    Eigen::AlignedBox3f box;
    std::uint32_t node;
  };
  std::vector<Root> roots_;
  std::vector<IndexNode> nodes_;
  std::size_t blocks_ = 0;
};

}  // namespace palpate
