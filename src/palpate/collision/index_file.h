/// \file
/// Index file, `SCENE.palpate` beside the scene: memory-mapped as it is, shared by all processes that use the
/// scene, and rebuilt when anything about it does not match.
///
/// All integers and floats are in the byte order of the processor that wrote them, which IndexFront records:
///
///     offset              bytes          what
///     0                   4096           IndexFront
///     4096                1024 b         GaussianBlock, b of them
///     ..                  448 n          IndexNode, n of them, the root first
///     ..                  8 c            XXH3 of every MiB before this table, the last one being shorter
///     ..                  4096           IndexTrailer
///
/// Data known only at the end is stored at the end, so that an index is written front to back while it is
/// built.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/base/mapped_file.h>
#include <palpate/collision/index_layout.h>
#include <palpate/collision/scene_index.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// The scene file that an index was built from.
struct IndexSource {
  FileStamp stamp;
  std::uint64_t content = 0;  ///< XXH3 of the bytes of the file, see content_hash()

  bool operator==(const IndexSource&) const = default;
};

/// XXH3 over the XXH3 of every 16 MiB of a file. Reads it on all cores. \throws Error.
std::uint64_t content_hash(const std::string& path);

/// The options that determine the contents of an index, as text: equal if and only if the indices are. The
/// registration is included only if the filter depends on it.
std::string index_options(const SceneFilter& filter, const Similarity& world_from_scene);

/// Metadata of an index file.
struct IndexDescription {
  IndexSource source;
  std::string options;  ///< see index_options()
  FilterReport report;  ///< of the scene it was built from
  std::uint64_t gaussians = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< IndexView::origin
};

/// The source of the index file `path`, read from its last page alone; nothing if it is not an index file of
/// this version.
std::optional<IndexSource> index_source(const std::string& path);

/// Writes an index file front to back.
class IndexWriter {
 public:
  /// \throws Error if `path` cannot be written.
  explicit IndexWriter(const std::string& path);

  void add(std::span<const GaussianBlock> blocks);
  /// Writes the nodes and the trailer. The file appears at `path` atomically; if an Error is thrown, nothing
  /// has changed.
  void finish(std::span<const IndexNode> nodes, const IndexDescription& description);

 private:
  void write(std::string_view bytes);

  OutputFile file_;
  std::string chunk_;  ///< written bytes that are not hashed yet
  std::vector<std::uint64_t> hashes_;
  std::uint64_t size_ = 0;
  std::uint64_t blocks_ = 0;
};

/// Index file loaded into memory.
class IndexFile final : public IndexStorage {
 public:
  /// Opens `path`, the index of the scene file `scene` under `options`, and reads all of it once, on all
  /// cores, to verify it: a damaged index must not determine the forces on a hand. \throws Error, whose
  /// message begins with `path`, if it is not an index, of another version or byte order, truncated,
  /// modified, of another scene, of an earlier state of the scene, or built with other options.
  IndexFile(const std::string& path, const std::string& scene, const std::string& options,
            FileMemory memory = FileMemory::kShared);

  IndexView view() const override { return view_; }
  const IndexDescription& description() const { return description_; }

 private:
  MappedFile file_;
  IndexDescription description_;
  IndexView view_;
};

}  // namespace palpate
