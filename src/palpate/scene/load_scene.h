/// \file
/// One door to every scene format.
#pragma once

#include <string>

#include <palpate/base/progress.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Reads a whole scene file of a format that open_scene() knows. Every row of the file is kept, defects
/// included, so that ids are rows.
/// \throws Error for anything that is not a whole scene of at least one Gaussian, naming the file,
/// the offset, property or row, and what to do.
GaussianScene load_scene(const std::string& path, const Progress& progress = {});

}  // namespace palpate
