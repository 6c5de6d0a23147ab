/// \file
/// The index of a scene as a file, `SCENE.palpate` beside the scene: mapped into memory as it is, shared by
/// all processes that use the scene, and made anew when anything about it does not fit.
///
/// All integers and floats in the byte order of the processor that wrote it, which the front tells:
///
///     offset              bytes          what
///     0                   4096           IndexFront
///     4096                1024 b         GaussianBlock, b of them
///     ..                  448 n          IndexNode, n of them, the root first
///     ..                  8 c            XXH3 of every MiB before this table, the last one being shorter
///     ..                  4096           IndexTrailer
///
/// What is only known at the end is at the end, so that an index is written front to back while it is made.
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

/// The scene file that an index was made of.
struct IndexSource {
  FileStamp stamp;
  std::uint64_t content = 0;  ///< XXH3 of the bytes of the file, see content_hash()

  bool operator==(const IndexSource&) const = default;
};

/// XXH3 over the XXH3 of every 16 MiB of a file. Reads it on all cores. \throws Error.
std::uint64_t content_hash(const std::string& path);

/// The options that decide what an index holds, as text: equal if and only if the indices are. The
/// registration is among them only where the filter depends on it.
std::string index_options(const SceneFilter& filter, const Similarity& world_from_scene);

/// What an index file says about itself, apart from the arrays.
struct IndexDescription {
  IndexSource source;
  std::string options;  ///< see index_options()
  FilterReport report;  ///< of the scene it was made of
  std::uint64_t gaussians = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< IndexView::origin
};

/// What the index file `path` was made of, from its last page alone; nothing where that is none of this
/// version.
std::optional<IndexSource> index_source(const std::string& path);

/// Writes an index file front to back.
class IndexWriter {
 public:
  /// \throws Error if `path` cannot be written.
  explicit IndexWriter(const std::string& path);

  void add(std::span<const GaussianBlock> blocks);
  /// What comes after the blocks, and the end. The file appears at `path`, whole, or an Error is thrown and
  /// nothing has happened.
  void finish(std::span<const IndexNode> nodes, const IndexDescription& description);

 private:
  void write(std::string_view bytes);

  OutputFile file_;
  std::string chunk_;  ///< of the bytes written, those that are not hashed yet
  std::vector<std::uint64_t> hashes_;
  std::uint64_t size_ = 0;
  std::uint64_t blocks_ = 0;
};

/// An index file in memory.
class IndexFile final : public IndexStorage {
 public:
  /// Takes in `path`, the index of the scene file `scene` under `options`, and reads all of it once, on all
  /// cores, to check it: a damaged one must not decide what a hand feels. \throws Error, whose message begins
  /// with `path`, if it is no index, of another version or byte order, cut, changed, of another scene, of an
  /// earlier state of the scene, or made with other options.
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
