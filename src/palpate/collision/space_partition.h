/// \file
/// Cutting a scene that is too large to be indexed at once into parts that are not.
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
  /// The share of a part of a hundred of these is known to a percent or so.
  static constexpr std::size_t kMost = std::size_t{1} << 18;

  std::vector<Eigen::Vector3f> positions_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

/// A k-d tree of planes that halve a sample, along its widest axis each time, until no part has more than its
/// share. Parts that follow each other are neighbours.
class SpacePartition {
 public:
  /// Parts of `sample` that stand for at most `most` of `total` records each.
  SpacePartition(std::vector<Eigen::Vector3f> sample, std::uint64_t total, std::size_t most);

  std::size_t parts() const { return parts_; }
  /// In [0, parts()). Any thread.
  std::size_t part_of(const std::array<float, 3>& position) const;

 private:
  /// Inner: what is below `plane` along `axis` is in the next node, the rest in `right`. Leaf: axis is 3, and
  /// `right` the part.
  struct Node {
    float plane;
    std::uint32_t axis, right;
  };
  void split(std::span<Eigen::Vector3f> sample, double weight, std::size_t most);

  std::vector<Node> nodes_;
  std::size_t parts_ = 0;
};

}  // namespace palpate
