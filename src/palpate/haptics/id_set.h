/// \file
/// Sets of Gaussians by their row in the scene file.
#pragma once

#include <cstdint>
#include <vector>

namespace palpate {

/// The ids first, first + 1, ..., last. \pre first <= last
struct IdRange {
  std::uint32_t first;
  std::uint32_t last;

  bool operator==(const IdRange&) const = default;
};

/// A set of ids, immutable.
class IdSet {
 public:
  /// Their union. They may overlap and come in any order.
  explicit IdSet(std::vector<IdRange> ranges);

  /// Takes time logarithmic in the number of ranges. Does not allocate.
  bool contains(std::uint32_t id) const;

  /// The fewest ranges that form the set, in increasing order.
  const std::vector<IdRange>& ranges() const { return ranges_; }

 private:
  std::vector<IdRange> ranges_;
};

}  // namespace palpate
