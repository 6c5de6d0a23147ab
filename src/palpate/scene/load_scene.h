/// \file
/// One door to every scene format.
#pragma once

#include <string>

#include <palpate/base/progress.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Reads a scene file. The format is told by its first bytes, and by the extension only where a
/// format has none of its own (`.splat`):
///   - INRIA `.ply` and its relatives, see ply_reader.h;
///   - `.splat`, see splat_reader.h.
/// Every row of the file is kept, defects included, so that ids are rows.
/// \throws Error for anything that is not a whole scene of at least one Gaussian, naming the file,
/// the offset, property or row, and what to do.
GaussianScene load_scene(const std::string& path, const Progress& progress = {});

}  // namespace palpate
