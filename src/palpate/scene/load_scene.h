/// \file
/// Loading of a whole scene of any supported format.
#pragma once

#include <string>

#include <palpate/base/progress.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Reads a whole scene file of any format that open_scene() supports. Keeps every row of the file, including
/// defective ones, so that ids are row numbers. \throws Error for anything that is not a complete scene of at
/// least one Gaussian, naming the file, the offset, property or row, and what to do.
GaussianScene load_scene(const std::string& path, const Progress& progress = {});

}  // namespace palpate
