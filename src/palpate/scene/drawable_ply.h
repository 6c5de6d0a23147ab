/// \file
/// Scene files in a form that the viewer draws.
#pragma once

#include <cstdint>
#include <string>

namespace palpate {

/// Returns whether the viewer (Spark) reads this scene file, and draws the Gaussians that are felt: a .splat,
/// or a .ply that is binary little-endian, has no element but `vertex`, only float properties, INRIA's
/// scale_2 and f_dc_0..2, an SH degree up to 3, and not Mip-Splatting's filter. \throws Error if it is not a
/// scene file.
bool is_drawable(const std::string& path);

/// Returns an upper bound of the size of the file that write_drawable_ply() makes of `path`. Unit: [bytes].
/// \throws Error if that is not a .ply scene.
std::uint64_t drawable_ply_bytes(const std::string& path);

/// Writes the .ply scene `from` as such a file: the same rows in the same order, in the captured frame, with
/// Mip-Splatting's filter applied, and the file's own colours up to SH degree 3; without any it is grey.
/// \throws Error if `from` cannot be read, as open_scene(), or `to` cannot be written.
void write_drawable_ply(const std::string& from, const std::string& to);

}  // namespace palpate
