/// \file
/// From a scene file to an index, the fastest way there is.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>

namespace palpate {

/// Where the index file of a scene file is: beside it. `garden.ply` and `garden.splat` have one each.
std::string index_path(const std::string& scene_path);

/// content_hash() of a scene file, from the index beside it where that was made of the file as it is now,
/// which needs no reading. \throws Error.
std::uint64_t scene_hash(const std::string& scene_path);

/// An index, and what is worth knowing about how it came to be.
struct OpenedIndex {
  SceneIndex index;
  FilterReport report;  ///< what became of the Gaussians of the scene
  /// Where the memory is: in the index file that was there, in one made now, or in this process alone.
  enum class Origin { kFile, kNewFile, kMemory } origin;
  /// Why an index file that was there is not used; and why there is none now. Lines for a person.
  std::optional<std::string> rejected, not_written;
};

/// How an index file may be used.
enum class IndexFiles {
  kUse,   ///< the one beside the scene is mapped; if there is none that fits, it is made
  kCopy,  ///< the same, but as a SharedCopy, which nothing that happens to the file can reach: for a loop
          ///< that a hand holds on to
  kNone,  ///< neither read nor written
};

/// The index of the Gaussians of the scene file `path` that `filter` keeps. Reads the scene only if there is
/// no index file that fits, and then in bounded memory: scenes of more than kMaxTreeRecords Gaussians are
/// sorted in a temporary file. Any number of processes may do this at once: the file appears whole, and
/// whoever makes it last stays. \throws Error as load_scene() does. What is wrong with an index file is no
/// error, it is made again.
OpenedIndex open_index(const std::string& path, const SceneFilter& filter, const Similarity& world_from_scene,
                       IndexFiles files = IndexFiles::kUse, const Progress& progress = {});

}  // namespace palpate
