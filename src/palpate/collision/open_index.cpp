#include <palpate/collision/open_index.h>

#include <filesystem>
#include <functional>
#include <utility>

#include <palpate/base/append.h>
#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/collision/index_file.h>
#include <palpate/collision/index_storage.h>
#include <palpate/collision/record_collector.h>
#include <palpate/collision/record_spill.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

/// A scene file and its filter.
struct Request {
  const std::string& path;
  const SceneFilter& filter;
  const Similarity& world_from_scene;
  const Progress& progress;
  FileMemory memory;  ///< of an index file

  RecordCollector collector() const { return {filter, world_from_scene}; }
};

/// Index not yet opened: its memory and the report.
struct Built {
  std::shared_ptr<const IndexArrays> arrays;
  FilterReport report;
};

/// Builds the index at once, in memory.
Built build_small(const Request& request, SceneReader& reader) {
  RecordCollector collector = request.collector();
  collector.reserve(reader.count());
  GaussianScene chunk;
  while (reader.next(chunk)) collector.add(chunk);
  return {build_arrays(collector.records(), reader.description().origin, request.progress),
          collector.report()};
}

/// Reads the scene to its end and passes on what the filter keeps, chunk by chunk; `collector` has the
/// report.
void for_each_chunk(SceneReader& reader, RecordCollector& collector,
                    const std::function<void(std::span<const GaussianRecord>)>& visit) {
  GaussianScene chunk;
  while (reader.next(chunk)) {
    collector.add(chunk);
    visit(collector.records());
    collector.clear();
  }
}

/// Result of building in parts, without the blocks.
struct BuiltParts {
  IndexForest forest;
  IndexDescription description;
};

/// Reads the scene twice: to sample the positions of its Gaussians, and to sort them into parts in a
/// temporary file. Then indexes each part and passes its blocks to `sink`.
BuiltParts build_in_parts(const Request& request, const std::string& spill_folder,
                          const std::function<void(std::vector<GaussianBlock>)>& sink) {
  BuiltParts built;
  PositionSample sample;
  const auto first_pass = open_scene(request.path, request.progress);
  RecordCollector collector = request.collector();
  for_each_chunk(*first_pass, collector, [&](auto records) { sample.add(records); });
  built.description.report = collector.report();
  built.description.gaussians = sample.seen();
  built.description.origin = first_pass->description().origin;

  const SpacePartition partition(sample.positions(), sample.seen(), kMaxTreeRecords / 2);
  RecordSpill spill(spill_folder, partition);
  const auto second_pass = open_scene(request.path, request.progress);
  for_each_chunk(*second_pass, collector, [&](auto records) { spill.add(records); });

  for (std::size_t part = 0; part < partition.parts(); ++part) {
    report(request.progress, "indexing", static_cast<double>(part) / static_cast<double>(partition.parts()));
    plant(spill.read(part), built.forest, sink);
  }
  report(request.progress, "indexing", 1.0);
  return built;
}

Built build_in_parts_in_memory(const Request& request, const std::string& spill_folder) {
  const auto arrays = std::make_shared<IndexArrays>();
  BuiltParts built = build_in_parts(request, spill_folder, [&](const std::vector<GaussianBlock>& blocks) {
    append(arrays->blocks, blocks);
  });
  arrays->nodes = built.forest.join();
  arrays->gaussians = built.description.gaussians;
  arrays->origin = built.description.origin;
  return {arrays, built.description.report};
}

/// Current state of the scene file. Taken before reading, so that a change during reading makes the index
/// stale.
IndexSource source_of(const std::string& path) { return {stamp_of(path), content_hash(path)}; }

void write_index(const IndexArrays& arrays, const IndexDescription& description, const std::string& path) {
  IndexWriter writer(path);
  writer.add(arrays.blocks);
  writer.finish(arrays.nodes, description);
}

void write_index_in_parts(const Request& request, const std::string& options, const std::string& path,
                          const std::string& spill_folder) {
  const IndexSource source = source_of(request.path);
  IndexWriter writer(path);
  BuiltParts built = build_in_parts(request, spill_folder,
                                    [&](const std::vector<GaussianBlock>& blocks) { writer.add(blocks); });
  built.description.source = source;
  built.description.options = options;
  writer.finish(built.forest.join(), built.description);
}

/// Opens the index file `path`. \throws Error as IndexFile.
OpenedIndex opened(const std::string& path, const std::string& options, const Request& request,
                   OpenedIndex::Origin origin) {
  auto file = std::make_shared<const IndexFile>(path, request.path, options, request.memory);
  const FilterReport report = file->description().report;
  return {SceneIndex(std::move(file), request.world_from_scene), report, origin, {}, {}};
}

OpenedIndex opened(const Built& built, const Request& request) {
  return {
      SceneIndex(built.arrays, request.world_from_scene), built.report, OpenedIndex::Origin::kMemory, {}, {}};
}

/// Builds the index of a scene without a matching index file, through a new file at `file`.
/// \param not_written is set to the reason if that cannot be written
OpenedIndex make_index(const Request& request, const std::string& options, const std::string& file,
                       std::optional<std::string>& not_written) {
  bool writable = !file.empty();
  if (writable) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(file, ignored);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
      not_written = fmt::format("{}: cannot be written: is not a regular file", file);
    } else if (!folder_is_writable(file)) {
      not_written = fmt::format("{}: cannot be written: the folder is read-only", file);
    }
    writable = !not_written;
  }
  const auto reader = open_scene(request.path, request.progress);

  if (reader->count() > kMaxTreeRecords) {
    const std::filesystem::path here = std::filesystem::path(file).parent_path();
    const std::string spill_folder = !writable      ? std::filesystem::temp_directory_path().string()
                                     : here.empty() ? "."
                                                    : here.string();
    if (!writable) return opened(build_in_parts_in_memory(request, spill_folder), request);
    write_index_in_parts(request, options, file, spill_folder);
    return opened(file, options, request, OpenedIndex::Origin::kNewFile);
  }

  if (!writable) return opened(build_small(request, *reader), request);
  const IndexSource source = source_of(request.path);
  const Built built = build_small(request, *reader);
  try {
    write_index(*built.arrays, {source, options, built.report, built.arrays->gaussians, built.arrays->origin},
                file);
    return opened(file, options, request, OpenedIndex::Origin::kNewFile);
  } catch (const Error& error) {
    not_written = error.what();
    return opened(built, request);
  }
}

}  // namespace

std::string index_path(const std::string& scene_path) { return scene_path + ".palpate"; }

std::uint64_t scene_hash(const std::string& scene_path) {
  const FileStamp now = stamp_of(scene_path);
  const auto seen = index_source(index_path(scene_path));
  return seen && seen->stamp == now ? seen->content : content_hash(scene_path);
}

OpenedIndex open_index(const std::string& path, const SceneFilter& filter, const Similarity& world_from_scene,
                       IndexFiles files, const Progress& progress) {
  check_filter(filter, world_from_scene);
  const FileMemory memory = files == IndexFiles::kCopy ? FileMemory::kOwn : FileMemory::kShared;
  const Request request{path, filter, world_from_scene, progress, memory};
  const std::string options = index_options(filter, world_from_scene);
  const std::string file = files != IndexFiles::kNone ? index_path(path) : std::string();
  std::optional<std::string> rejected;
  std::error_code ignored;
  if (!file.empty() && std::filesystem::exists(file, ignored) && std::filesystem::exists(path, ignored)) {
    try {
      return opened(file, options, request, OpenedIndex::Origin::kFile);
    } catch (const Error& error) {
      rejected = error.what();
    }
  }
  std::optional<std::string> not_written;
  OpenedIndex result = make_index(request, options, file, not_written);
  result.rejected = std::move(rejected);
  result.not_written = std::move(not_written);
  return result;
}

}  // namespace palpate
