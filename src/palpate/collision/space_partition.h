/// \file
/// Spatial partition of a scene that is too large to be indexed in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/collision/index_builder.h>

namespace palpate {

/// A bounded, evenly strided sample of the positions of a stream of records.
class PositionSample {
 public:
  void add(std::span<const GaussianRecord> records);

  std::uint64_t seen() const { return seen_; }
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }

 private:
  /// Maximum sample size: the share of a part that is a hundredth of the scene is known to about a percent.
  static constexpr std::size_t kMost = std::size_t{1} << 18;

  std::vector<Eigen::Vector3f> positions_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

/// A k-d tree that halves a sample along its widest axis until no part exceeds its share. Consecutive parts
/// are neighbours in space.
class SpacePartition {
 public:
  /// Partitions `sample` into parts that represent at most `most` of `total` records each.
  SpacePartition(std::vector<Eigen::Vector3f> sample, std::uint64_t total, std::size_t most);

  std::size_t parts() const { return parts_; }
  /// Index of the part that contains `position`, in [0, parts()). Any thread.
  std::size_t part_of(const std::array<float, 3>& position) const;

 private:
  /// Inner node: positions below `plane` along `axis` are in the next node, the rest in `right`. Leaf: axis
  /// is 3, and `right` is the part.
  struct Node {
    float plane;
    std::uint32_t axis, right;
  };
  void split(std::span<Eigen::Vector3f> sample, double weight, std::size_t most);

  std::vector<Node> nodes_;
  std::size_t parts_ = 0;
};

}  // namespace palpate
