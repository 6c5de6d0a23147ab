// Material files: read_materials() either throws Error or returns regions with values within their bounds,
// from which a map can be built.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/haptics/material_file.h>

#include "input_file.h"

namespace {

using palpate::fuzz::require;

void check(const std::optional<double>& value, palpate::MaterialProperty property) {
  require(!value || (*value >= 0.0 && *value <= palpate::kMaterialProperties[property].most));
}

void check(const palpate::Material& material) {
  check(material.stiffness, palpate::kMaterialStiffness);
  check(material.friction, palpate::kMaterialFriction);
  check(material.damping, palpate::kMaterialDamping);
}

/// Material of `map` at a point inside `region`.
palpate::Material inside(const palpate::MaterialMap& map, const palpate::MaterialRegion& region) {
  std::uint32_t id = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  if (const auto* box = std::get_if<Eigen::AlignedBox3d>(&region.shape)) center = box->max();
  if (const auto* sphere = std::get_if<palpate::MaterialSphere>(&region.shape)) center = sphere->center;
  if (const auto* ids = std::get_if<palpate::IdSet>(&region.shape)) id = ids->ranges().back().last;
  require(region.contains(id, center));
  return map.of(id, center);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file;
  try {
    const auto regions = palpate::read_materials(file.hold(data, size, "materials.toml"));
    require(!regions.empty() && regions.size() <= palpate::kMaxMaterialRegions);
    const palpate::MaterialMap map(regions);
    for (const palpate::MaterialRegion& region : regions) {
      check(region.material);
      require(inside(map, region) != palpate::Material{});
    }
    require(inside(map, regions.back()) == over(regions.back().material, inside(map, regions.back())));
  } catch (const palpate::Error&) {
  }
  return 0;
}
