#include <palpate/haptics/material.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

/// Returns true if a shape contains a Gaussian.
struct Contains {
  std::uint32_t id;
  const Eigen::Vector3d& center;

  bool operator()(MaterialRegion::Everywhere) const { return true; }
  bool operator()(const Eigen::AlignedBox3d& box) const { return box.contains(center); }
  bool operator()(const MaterialSphere& sphere) const {
    return (center - sphere.center).squaredNorm() <= sphere.radius * sphere.radius;
  }
  bool operator()(const IdSet& ids) const { return ids.contains(id); }
};

std::optional<double> or_else(const std::optional<double>& top, const std::optional<double>& below) {
  return top ? top : below;
}

bool complete(const Material& m) { return m.stiffness && m.friction && m.damping; }

std::optional<double> of_row(const std::vector<float>& values, std::uint32_t row) {
  if (row >= values.size() || std::isnan(values[row])) return std::nullopt;
  return values[row];
}

}  // namespace

Material over(const Material& top, const Material& below) {
  return {or_else(top.stiffness, below.stiffness), or_else(top.friction, below.friction),
          or_else(top.damping, below.damping)};
}

bool MaterialRegion::contains(std::uint32_t id, const Eigen::Vector3d& center) const {
  return std::visit(Contains{id, center}, shape);
}

MaterialMap::MaterialMap(std::vector<MaterialRegion> regions, PlyMaterials rows)
    : regions_(std::move(regions)), rows_(std::move(rows)) {
  std::reverse(regions_.begin(), regions_.end());
}

Material MaterialMap::of(std::uint32_t id, const Eigen::Vector3d& center) const {
  Material material;
  for (const MaterialRegion& region : regions_) {
    if (region.contains(id, center)) material = over(material, region.material);
    if (complete(material)) return material;
  }
  return over(material,
              {of_row(rows_.values[kMaterialStiffness], id), of_row(rows_.values[kMaterialFriction], id),
               of_row(rows_.values[kMaterialDamping], id)});
}

}  // namespace palpate
