/// \file
/// Writer of scenes as INRIA .ply, the layout that every viewer reads.
#pragma once

#include <string>

#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/ply_materials.h>

namespace palpate {

/// Writes binary little-endian INRIA .ply with the properties x y z, nx ny nz (zero), f_dc_0..2, opacity
/// (logit), scale_0..2 (log), rot_0..3, all float, SH degree 0, and the stiffness, friction and damping
/// columns that `materials` has, row by row. `comment` goes into the header. The file appears atomically.
/// Rows are written in order; ids are not kept. \pre a column of `materials` is empty or as long as the scene
/// \throws Error if the file cannot be written.
void write_ply(const GaussianScene& scene, const std::string& path, const std::string& comment,
               const PlyMaterials& materials = {});

/// The bytes of such a file.
std::string ply_bytes(const GaussianScene& scene, const std::string& comment);

}  // namespace palpate
