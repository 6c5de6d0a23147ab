/// \file
/// What the Gaussians of a .ply are made of, where it says so.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/scene/material_properties.h>

namespace palpate {

/// Material properties by row of the scene file.
struct PlyMaterials {
  /// By MaterialProperty: one number a row, NaN where it is not set; empty if the file has no such property.
  std::array<std::vector<float>, kMaterialPropertyCount> values;

  /// True if there is no property at all.
  bool empty() const;
};

/// Reads the properties `stiffness`, `friction` and `damping` of the element `vertex`, as many as there are,
/// of any numeric type, in ASCII or binary. Of a file that has none, or is no .ply, only the header is read.
/// \throws Error as open_ply() does, and for a number that is negative, infinite or too large.
PlyMaterials read_ply_materials(const std::string& path, const Progress& progress = {});

}  // namespace palpate
