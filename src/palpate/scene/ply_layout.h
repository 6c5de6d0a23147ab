/// \file
/// Validation of a .ply as a Gaussian splatting scene, and detection of its variant.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <palpate/scene/material_properties.h>
#include <palpate/scene/ply_header.h>

namespace palpate {

/// Properties of the element `vertex` that are read.
enum PlyField : std::size_t {
  kX,
  kY,
  kZ,
  kScale0,
  kScale1,
  kScale2,
  kRot0,
  kRot1,
  kRot2,
  kRot3,
  kOpacity,
  kFilter,
  kRed,
  kGreen,
  kBlue,
  kFirstMaterial,  ///< followed by the others, by MaterialProperty
  kPlyFieldCount = kFirstMaterial + kMaterialPropertyCount
};

/// Their names, by PlyField.
inline constexpr std::array<const char*, kPlyFieldCount> kPlyFieldNames{
    "x",
    "y",
    "z",
    "scale_0",
    "scale_1",
    "scale_2",
    "rot_0",
    "rot_1",
    "rot_2",
    "rot_3",
    "opacity",
    "filter_3D",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
    kMaterialProperties[kMaterialStiffness].name,
    kMaterialProperties[kMaterialFriction].name,
    kMaterialProperties[kMaterialDamping].name};

struct PlyLayout {
  std::string variant;  ///< "INRIA", "2DGS" or "Mip-Splatting"
  int sh_degree = 0;
  bool wide_positions = false;         ///< positions may exceed single precision
  std::vector<const char*> materials;  ///< names of the material properties present
};

/// Checks that `vertex` has the properties of a Gaussian splatting scene, see ply_reader.h.
/// \throws Error naming `path` and the property otherwise.
PlyLayout check_layout(const std::string& path, const PlyElement& vertex);

}  // namespace palpate
