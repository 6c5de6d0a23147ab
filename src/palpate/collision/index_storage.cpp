#include <palpate/collision/index_storage.h>

#include <algorithm>
#include <utility>

#include <palpate/base/append.h>
#include <palpate/collision/record_collector.h>
#include <palpate/collision/space_partition.h>

namespace palpate {
namespace {

/// Reorders `records` by part; `end` receives the end of each part.
std::vector<GaussianRecord> gathered(const std::vector<GaussianRecord>& records,
                                     const SpacePartition& partition, std::vector<std::size_t>& end) {
  end.assign(partition.parts(), 0);
  std::vector<std::uint32_t> part(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    part[i] = static_cast<std::uint32_t>(partition.part_of(records[i].position));
    ++end[part[i]];
  }
  std::size_t first = 0;
  for (std::size_t& e : end) e = std::exchange(first, first + e);
  std::vector<GaussianRecord> sorted(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) sorted[end[part[i]]++] = records[i];
  return sorted;
}

}  // namespace

IndexView IndexArrays::view() const { return {nodes, blocks, gaussians, origin}; }

void plant(std::span<const GaussianRecord> records, IndexForest& forest,
           const std::function<void(std::vector<GaussianBlock>)>& sink) {
  for (std::size_t first = 0; first < records.size(); first += kMaxTreeRecords) {
    const auto part = records.subspan(first, std::min(kMaxTreeRecords, records.size() - first));
    sink(forest.plant(build_tree(part, boxes_of(part))));
  }
}

std::shared_ptr<const IndexArrays> build_arrays(const std::vector<GaussianRecord>& records,
                                                const Eigen::Vector3d& origin, const Progress& progress) {
  report(progress, "indexing", 0.0);
  const auto arrays = std::make_shared<IndexArrays>();
  arrays->gaussians = records.size();
  arrays->origin = origin;
  IndexForest forest;
  const auto keep = [&](std::vector<GaussianBlock> blocks) {
    if (arrays->blocks.empty()) {
      arrays->blocks = std::move(blocks);
    } else {
      append(arrays->blocks, blocks);
    }
  };
  if (records.size() <= kMaxTreeRecords) {
    plant(records, forest, keep);
  } else {
    PositionSample sample;
    sample.add(records);
    const SpacePartition partition(sample.positions(), sample.seen(), kMaxTreeRecords / 2);
    std::vector<std::size_t> ends;
    const std::vector<GaussianRecord> sorted = gathered(records, partition, ends);
    std::size_t first = 0;
    for (const std::size_t end : ends) {
      report(progress, "indexing", static_cast<double>(first) / static_cast<double>(records.size()));
      plant(std::span(sorted).subspan(first, end - first), forest, keep);
      first = end;
    }
  }
  arrays->nodes = forest.join();
  report(progress, "indexing", 1.0);
  return arrays;
}

}  // namespace palpate
