/// \file
/// Timing of opening a scene file for queries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/open_index.h>

namespace palpate {

/// Figures of opening a scene file for queries.
struct OpenFigures {
  double seconds = 0.0;
  std::string origin;                      ///< "index file", "new index file" or "memory"
  std::vector<std::string> remarks;        ///< why an index file was not used or not written
  std::uint64_t scene_bytes = 0;           ///< of the scene file
  std::optional<std::size_t> index_bytes;  ///< unset for a pipeline that does not report it
  std::size_t gaussians = 0;               ///< number that can be touched
  std::size_t peak_bytes = 0;              ///< largest resident set so far, mapped files included
};

/// An index, and figures on how it was opened.
struct TimedIndex {
  SceneIndex index;
  OpenFigures figures;
};

/// Calls open_index() and measures it. \throws Error as it does.
TimedIndex time_opening(const std::string& path, const SceneFilter& filter,
                        const Similarity& world_from_scene, IndexFiles files, const Progress& progress = {});

/// Sets the sizes of the scene file and of this process. \throws Error if the file cannot be read.
void measure_sizes(const std::string& path, OpenFigures& figures);

}  // namespace palpate
