/// \file
/// Cost of a scene file: indexing in bounded memory, opening, and contact queries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "comparison.h"

namespace palpate::bench {

struct SceneFileResult {
  std::string path;
  std::uint64_t scene_bytes = 0, index_bytes = 0;  ///< sizes of the files
  double index_seconds = 0.0;                      ///< from the scene file to the index file, all cores
  std::size_t index_anonymous = 0;                 ///< peak anonymous memory meanwhile. Unit: [bytes].
  /// Time from opening an existing index file to the first contact: not in the page cache, and in it.
  /// Unit: [s].
  double first_contact_cold = 0.0, first_contact_warm = 0.0;
  /// This library only: poses of strokes, and poses at random places of the whole scene.
  Comparison strokes, whole_scene;
};

/// Measures the scene file `path`, written by make_bench_scene with the seed of the poses. Replaces the index
/// file beside it. Prints its progress on stderr. \throws Error if the file cannot be read, its index cannot
/// be written, or no pose is in contact.
SceneFileResult measure_scene_file(const std::string& path, const ComparisonOptions& options);

}  // namespace palpate::bench
