/// \file
/// Opens the index of a scene file: from its index file if that is valid, else by building it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>

namespace palpate {

/// Path of the index file of a scene file, beside it. `garden.ply` and `garden.splat` have one each.
std::string index_path(const std::string& scene_path);

/// content_hash() of a scene file, taken without reading it from the index file beside it if that was built
/// from the file in its current state. \throws Error.
std::uint64_t scene_hash(const std::string& scene_path);

/// An index and how it was obtained.
struct OpenedIndex {
  SceneIndex index;
  FilterReport report;  ///< of the Gaussians of the scene
  /// Where the index resides: in an existing index file, in a new one, or in the memory of this process
  /// alone.
  enum class Origin { kFile, kNewFile, kMemory } origin;
  /// Why an existing index file was not used, and why no new one was written. One human-readable line each.
  std::optional<std::string> rejected, not_written;
};

/// How index files may be used.
enum class IndexFiles {
  kUse,   ///< maps the one beside the scene; writes it if there is none that matches
  kCopy,  ///< the same, but as a SharedCopy, unaffected by later changes to the file: for a loop
          ///< that a hand holds on to
  kNone,  ///< neither read nor written
};

/// The index of the Gaussians of the scene file `path` that `filter` keeps. Reads the scene only if no index
/// file matches, and then in bounded memory: scenes of more than kMaxTreeRecords Gaussians are sorted in a
/// temporary file. Any number of processes may do this concurrently: the file appears atomically, and the
/// last one written stays. \throws Error as load_scene() and check_filter() do. A defective index file is no
/// error; it is rebuilt.
OpenedIndex open_index(const std::string& path, const SceneFilter& filter, const Similarity& world_from_scene,
                       IndexFiles files = IndexFiles::kUse, const Progress& progress = {});

}  // namespace palpate
