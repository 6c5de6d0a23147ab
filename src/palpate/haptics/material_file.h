/// \file
/// Material files of scenes, see docs/materials.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/haptics/material.h>

namespace palpate {

/// Bounds on a material file: some hundred thousand ids, and at most as many regions as the servo loop can
/// check for every contact.
inline constexpr std::uint64_t kMaxMaterialBytes = std::uint64_t{4} << 20;
inline constexpr std::size_t kMaxMaterialRegions = 256;

/// Reads regions in the order of the file, the topmost last:
///
///     [[region]]
///     name = "rubber mat"                            # for people
///     box = { min = [0, 0, 0], max = [1, 1, 0.1] }   # world frame, m; or
///     sphere = { center = [0, 0, 0], radius = 0.2 }  # likewise; or
///     ids = [3, 17, [100, 200]]                      # rows of the scene file; or none of these: everywhere
///     stiffness = 800.0                              # N/m; at least one of
///     friction = 0.6                                 #
///     damping = 2.0                                  # N s/m
///
/// \throws Error with file and line for anything else.
std::vector<MaterialRegion> read_materials(const std::string& path);

}  // namespace palpate
