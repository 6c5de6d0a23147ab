/// \file
/// In-memory storage of an index.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/index_builder.h>
#include <palpate/collision/scene_index.h>

namespace palpate {

/// Index that owns arrays of nodes and blocks.
class IndexArrays final : public IndexStorage {
 public:
  std::vector<IndexNode> nodes;
  std::vector<GaussianBlock> blocks;
  std::uint64_t gaussians = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< captured frame

  IndexView view() const override;
};

/// Adds a part of a scene to a forest, as one tree or, above kMaxTreeRecords, as several; passes the blocks
/// to `sink` in order.
void plant(std::span<const GaussianRecord> records, IndexForest& forest,
           const std::function<void(std::vector<GaussianBlock>)>& sink);

/// Builds the index of `records`, whose positions are relative to `origin`.
std::shared_ptr<const IndexArrays> build_arrays(const std::vector<GaussianRecord>& records,
                                                const Eigen::Vector3d& origin, const Progress& progress);

}  // namespace palpate
