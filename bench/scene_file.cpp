#include "scene_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/core.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/collision/open_index.h>
#include <palpate/scene/scene_reader.h>

namespace palpate::bench {
namespace {

/// Asks the system to drop a file from the page cache, so that the next read waits for the disk. Pages that
/// another process maps stay.
void evict(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  fdatasync(file);  // dirty pages cannot be dropped
  posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  close(file);
}

OpenedIndex open_as(OpenedIndex::Origin expected, const std::string& path, const SceneFilter& filter) {
  OpenedIndex opened = open_index(path, filter, Similarity{});
  if (opened.origin != expected) {
    throw Error("{}: the index file was not {}: {}", path,
                expected == OpenedIndex::Origin::kFile ? "used" : "written",
                opened.not_written.value_or(opened.rejected.value_or("no reason was given")));
  }
  return opened;
}

/// Makes the index file. \returns the number of Gaussians of the scene, including filtered ones
std::size_t make_index_file(const SceneFilter& filter, SceneFileResult& result) {
  fmt::print(stderr, "indexing {}\n", result.path);
  std::filesystem::remove(index_path(result.path));
  const AnonymousMemoryWatch memory;
  const Stopwatch watch;
  const OpenedIndex opened = open_as(OpenedIndex::Origin::kNewFile, result.path, filter);
  result.index_seconds = watch.seconds();
  result.index_anonymous = memory.peak();
  result.scene_bytes = stamp_of(result.path).size;
  result.index_bytes = stamp_of(index_path(result.path)).size;
  return opened.report.total;
}

/// Poses of the tool and their true contacts.
struct Order {
  std::vector<Ellipsoid> poses;
  Truth truth;
};

/// Computes the truth of all orders in one pass over the file.
void find_truth(const std::string& path, const SceneFilter& filter, std::array<Order, 2>& orders) {
  fmt::print(stderr, "computing the truth\n");
  std::array finders{TruthFinder(orders[0].poses), TruthFinder(orders[1].poses)};
  const auto reader = open_scene(path);
  GaussianScene chunk;
  while (reader->next(chunk)) {
    FilterReport report;
    const EllipsoidScene kept = filter_scene(chunk, filter, Similarity{}, report);
    for (TruthFinder& finder : finders) finder.add(kept);
  }
  for (std::size_t i = 0; i < orders.size(); ++i) orders[i].truth = finders[i].take();
}

/// Time to open the index file and find the first contact. Unit: [s].
double time_first_contact(const std::string& path, const SceneFilter& filter, const Ellipsoid& touching) {
  ContactSet contacts;
  const Stopwatch watch;
  const OpenedIndex opened = open_as(OpenedIndex::Origin::kFile, path, filter);
  opened.index.query(touching, contacts);
  const double seconds = watch.seconds();
  if (contacts.contacts.empty()) throw Error("{}: the first contact was not found", path);
  return seconds;
}

void time_first_contacts(const SceneFilter& filter, const Ellipsoid& touching, SceneFileResult& result) {
  fmt::print(stderr, "opening\n");
  evict(index_path(result.path));
  result.first_contact_cold = time_first_contact(result.path, filter, touching);
  result.first_contact_warm = time_first_contact(result.path, filter, touching);
}

/// Opens the index file again and runs all poses of `order`.
void compare(const SceneFilter& filter, const Order& order, const SceneFileResult& file,
             Comparison& comparison) {
  OpenedIndex opened = open_as(OpenedIndex::Origin::kFile, file.path, filter);
  Pipelines pipelines =
      pipelines_of(std::make_shared<SceneIndex>(std::move(opened.index)), comparison.options.every_target);
  for (const auto& pipeline : pipelines) {
    PipelineResult& result = comparison.results.emplace_back();
    result.name = pipeline->name();
    result.family = families().front();
    result.build_seconds = file.index_seconds;
    result.bytes = file.index_bytes;
  }
  run(pipelines, order.poses, order.truth, comparison);
}

/// First pose in contact.
const Ellipsoid& first_touching(const Order& order, const std::string& path, std::uint64_t seed) {
  for (std::size_t i = 0; i < order.poses.size(); ++i)
    if (!order.truth[i].empty()) return order.poses[i];
  throw Error("{}: no pose touches anything; make it with make_bench_scene --seed {}", path, seed);
}

}  // namespace

SceneFileResult measure_scene_file(const std::string& path, const ComparisonOptions& options) {
  SceneFileResult result;
  result.path = path;
  SceneFilter filter;
  filter.sigma = options.sigma;
  const std::size_t gaussians = make_index_file(filter, result);
  const BenchScene scene(gaussians, options.poses.seed, options.spacing);

  std::array<Comparison*, 2> comparisons{&result.strokes, &result.whole_scene};
  std::array<Order, 2> orders;
  for (std::size_t i = 0; i < orders.size(); ++i) {
    ComparisonOptions& own = comparisons[i]->options;
    own = options;
    own.gaussians = gaussians;
    own.poses.whole_scene = i == 1;
    orders[i].poses = make_poses(scene, own.poses);
  }
  find_truth(path, filter, orders);
  time_first_contacts(filter, first_touching(orders[0], path, options.poses.seed), result);
  for (std::size_t i = 0; i < orders.size(); ++i) compare(filter, orders[i], result, *comparisons[i]);
  return result;
}

}  // namespace palpate::bench
