/// \file
/// Per-Gaussian material properties of a .ply.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/scene/material_properties.h>

namespace palpate {

/// Material properties by row of the scene file.
struct PlyMaterials {
  /// Indexed by MaterialProperty: one number per row, NaN where it is not set; empty if the file lacks the
  /// property.
  std::array<std::vector<float>, kMaterialPropertyCount> values;

  /// True if the file has no material property.
  bool empty() const;
};

/// Reads whichever of the properties `stiffness`, `friction` and `damping` the element `vertex` has, of any
/// numeric type, in ASCII or binary. If there are none, or the file is not a .ply, only the header is read.
/// \throws Error as open_ply() does, and for a number that is negative, infinite or too large.
PlyMaterials read_ply_materials(const std::string& path, const Progress& progress = {});

}  // namespace palpate
