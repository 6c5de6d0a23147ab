#include <palpate/haptics/id_set.h>

#include <algorithm>
#include <utility>

namespace palpate {

IdSet::IdSet(std::vector<IdRange> ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const IdRange& a, const IdRange& b) { return a.first < b.first; });
  for (const IdRange& range : ranges) {
    if (!ranges_.empty() && range.first <= std::uint64_t{ranges_.back().last} + 1) {
      ranges_.back().last = std::max(ranges_.back().last, range.last);
    } else {
      ranges_.push_back(range);
    }
  }
}

bool IdSet::contains(std::uint32_t id) const {
  const auto next = std::upper_bound(ranges_.begin(), ranges_.end(), id,
                                     [](std::uint32_t i, const IdRange& range) { return i < range.first; });
  return next != ranges_.begin() && id <= std::prev(next)->last;
}

}  // namespace palpate
