#include <palpate/study/open_timing.h>

#include <utility>

#include <sys/resource.h>

#include <palpate/base/file.h>
#include <palpate/study/latency.h>

namespace palpate {
namespace {

/// Largest resident set of this process until now. Unit: [bytes].
std::size_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

const char* name_of(OpenedIndex::Origin origin) {
  switch (origin) {
    case OpenedIndex::Origin::kFile: return "index file";
    case OpenedIndex::Origin::kNewFile: return "new index file";
    default: return "memory";
  }
}

}  // namespace

TimedIndex time_opening(const std::string& path, const SceneFilter& filter,
                        const Similarity& world_from_scene, IndexFiles files, const Progress& progress) {
  OpenFigures figures;
  const Stopwatch watch;
  OpenedIndex opened = open_index(path, filter, world_from_scene, files, progress);
  figures.seconds = watch.seconds();
  figures.origin = name_of(opened.origin);
  for (const auto& remark : {opened.rejected, opened.not_written})
    if (remark) figures.remarks.push_back(*remark);
  figures.index_bytes = opened.index.bytes();
  figures.gaussians = opened.index.size();
  return {std::move(opened.index), std::move(figures)};
}

void measure_sizes(const std::string& path, OpenFigures& figures) {
  figures.peak_bytes = peak_resident_bytes();
  figures.scene_bytes = stamp_of(path).size;
}

}  // namespace palpate
