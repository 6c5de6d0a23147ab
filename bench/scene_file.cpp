#include "scene_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
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

/// Has the system forget what it keeps of a file in memory, so that the next to read it waits for the disk. A
/// wish: pages that someone else maps stay.
void evict(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  fdatasync(file);  // what is not on the disk yet cannot be forgotten
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

/// Makes the index file; returns how many Gaussians the scene has, dropped ones included.
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

Truth truth_of_file(const std::string& path, const SceneFilter& filter, const std::vector<Ellipsoid>& poses) {
  fmt::print(stderr, "computing the truth\n");
  TruthFinder finder(poses);
  const auto reader = open_scene(path);
  GaussianScene chunk;
  while (reader->next(chunk)) {
    FilterReport report;
    finder.add(filter_scene(chunk, filter, Similarity{}, report));
  }
  return finder.take();
}

/// Unit: [s].
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

/// Opens the index file once more, to be queried, and fills in the results but for what run() does.
Pipelines open_pipelines(const SceneFilter& filter, const SceneFileResult& file, Comparison& comparison) {
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
  return pipelines;
}

}  // namespace

SceneFileResult measure_scene_file(const std::string& path, const ComparisonOptions& options) {
  SceneFileResult result;
  result.path = path;
  Comparison& comparison = result.comparison;
  comparison.options = options;
  SceneFilter filter;
  filter.sigma = options.sigma;
  comparison.options.gaussians = make_index_file(filter, result);

  const BenchScene scene(comparison.options.gaussians, options.poses.seed, options.spacing);
  const std::vector<Ellipsoid> poses = make_poses(scene, options.poses);
  const Truth truth = truth_of_file(path, filter, poses);
  const auto touching =
      std::find_if(truth.begin(), truth.end(), [](const auto& hits) { return !hits.empty(); });
  if (touching == truth.end()) {
    throw Error("{}: no pose touches anything; make it with make_bench_scene --seed {}", path,
                options.poses.seed);
  }
  time_first_contacts(filter, poses[static_cast<std::size_t>(touching - truth.begin())], result);
  Pipelines pipelines = open_pipelines(filter, result, comparison);
  run(pipelines, poses, truth, comparison);
  return result;
}

}  // namespace palpate::bench
