/// \file
/// Material properties and their names in files.
#pragma once

#include <array>
#include <cstddef>

namespace palpate {

enum MaterialProperty : std::size_t {
  kMaterialStiffness,
  kMaterialFriction,
  kMaterialDamping,
  kMaterialPropertyCount
};

/// Name, unit and range of a MaterialProperty in files.
struct MaterialPropertyFormat {
  const char* name;
  const char* unit;
  double most;  ///< maximum; the minimum is 0
};

/// Indexed by MaterialProperty. The bounds are far beyond what a device can render, and reject typing errors.
inline constexpr std::array<MaterialPropertyFormat, kMaterialPropertyCount> kMaterialProperties{
    {{"stiffness", "N/m", 1e6}, {"friction", "1", 10.0}, {"damping", "N s/m", 1e4}}};

}  // namespace palpate
