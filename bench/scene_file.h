/// \file
/// What a scene file costs: to index in bounded memory, to open, and to touch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "comparison.h"

namespace palpate::bench {

struct SceneFileResult {
  std::string path;
  std::uint64_t scene_bytes = 0, index_bytes = 0;  ///< of the files
  double index_seconds = 0.0;                      ///< from the scene file to the index file, all cores
  std::size_t index_anonymous = 0;                 ///< most anonymous memory meanwhile. Unit: [bytes].
  /// From nothing to the first contact with the index file there: with none of it in memory, and again. Unit:
  /// [s].
  double first_contact_cold = 0.0, first_contact_warm = 0.0;
  /// This library alone; with strokes, and with every pose somewhere else in the scene.
  Comparison strokes, whole_scene;
};

/// Indexes, opens and touches the scene file `path`, which make_bench_scene has written with the seed of the
/// poses. The index beside it is made anew. Says on stderr what it is doing. \throws Error if the file cannot
/// be read, its index not be written, or no pose touches anything.
SceneFileResult measure_scene_file(const std::string& path, const ComparisonOptions& options);

}  // namespace palpate::bench
