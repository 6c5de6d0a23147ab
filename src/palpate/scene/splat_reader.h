/// \file
/// Reader of the `.splat` format of browser viewers.
#pragma once

#include <memory>

#include <palpate/base/file.h>
#include <palpate/base/progress.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {

/// Reads `.splat`: no header, 32 bytes per Gaussian, little-endian:
///
///     offset  0  float[3]  position
///     offset 12  float[3]  sigma (linear)
///     offset 24  uint8[4]  red, green, blue (sRGB), opacity / 255
///     offset 28  uint8[4]  quaternion w, x, y, z as (byte - 128) / 128
///
/// \throws Error if the size is not a multiple of 32.
std::unique_ptr<SceneReader> open_splat(InputFile file, const Progress& progress = {});

/// Reads the whole scene.
GaussianScene read_splat(InputFile file, const Progress& progress = {});

}  // namespace palpate
