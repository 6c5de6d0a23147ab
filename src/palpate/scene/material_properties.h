/// \file
/// The numbers that say what something is made of, as files name them.
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

/// How a MaterialProperty is written in a file.
struct MaterialPropertyFormat {
  const char* name;
  const char* unit;
  double most;  ///< the largest that is taken; the least is 0
};

/// By MaterialProperty. The bounds are far beyond what a device can render, and keep slips of the pen out.
inline constexpr std::array<MaterialPropertyFormat, kMaterialPropertyCount> kMaterialProperties{
    {{"stiffness", "N/m", 1e6}, {"friction", "1", 10.0}, {"damping", "N s/m", 1e4}}};

}  // namespace palpate
