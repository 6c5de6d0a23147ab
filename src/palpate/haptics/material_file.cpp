#include <palpate/haptics/material_file.h>

#include <limits>
#include <optional>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {
namespace {

Eigen::Vector3d read_point(const TomlValue& value) {
  const auto p = value.numbers<3>(-kMaxExtent, kMaxExtent);
  return {p[0], p[1], p[2]};
}

Eigen::AlignedBox3d read_box(TomlTable table) {
  const Eigen::AlignedBox3d box(read_point(table.at("min")), read_point(table.at("max")));
  table.refuse_others();
  if (box.isEmpty()) throw Error("{}: 'min' of the box must not be above 'max'", table.where());
  return box;
}

MaterialSphere read_sphere(TomlTable table) {
  MaterialSphere sphere{read_point(table.at("center")), table.at("radius").number(0.0, kMaxExtent)};
  table.refuse_others();
  return sphere;
}

std::uint32_t read_id(const TomlValue& value) {
  return static_cast<std::uint32_t>(value.integer(0, std::numeric_limits<std::uint32_t>::max()));
}

IdRange read_id_range(const TomlValue& value) {
  if (!value.is_array()) return {read_id(value), read_id(value)};
  const std::vector<TomlValue> ends = value.items();
  if (ends.size() != 2) throw value.must_be("ids and ranges [first, last]");
  const IdRange range{read_id(ends[0]), read_id(ends[1])};
  if (range.first > range.last)
    throw Error("{}: the range [{}, {}] ends before it begins", value.where(), range.first, range.last);
  return range;
}

IdSet read_ids(const TomlValue& value) {
  std::vector<IdRange> ranges;
  for (const TomlValue& item : value.items()) ranges.push_back(read_id_range(item));
  if (ranges.empty()) throw value.must_be("ids and ranges [first, last]");
  return IdSet(std::move(ranges));
}

MaterialRegion::Shape read_shape(TomlTable& region) {
  const auto box = region.find("box"), sphere = region.find("sphere"), ids = region.find("ids");
  if (box.has_value() + sphere.has_value() + ids.has_value() > 1)
    throw Error("{}: a region has one shape; keep one of box, sphere and ids", region.where());
  if (box) return read_box(box->table());
  if (sphere) return read_sphere(sphere->table());
  if (ids) return read_ids(*ids);
  return MaterialRegion::Everywhere{};
}

std::optional<double> read_property(TomlTable& region, MaterialProperty property) {
  const auto& [name, unit, most] = kMaterialProperties[property];
  const auto value = region.find(name);
  if (!value) return std::nullopt;
  return value->number(0.0, most);
}

MaterialRegion read_region(TomlTable region) {
  if (const auto name = region.find("name")) name->text();
  MaterialRegion result{read_shape(region),
                        {read_property(region, kMaterialStiffness), read_property(region, kMaterialFriction),
                         read_property(region, kMaterialDamping)}};
  region.refuse_others();
  if (result.material == Material{})
    throw Error("{}: the region changes nothing; give stiffness, friction or damping", region.where());
  return result;
}

}  // namespace

std::vector<MaterialRegion> read_materials(const std::string& path) {
  const TomlFile file(path, kMaxMaterialBytes);
  TomlTable root = file.root();
  const auto list = root.find("region");
  root.refuse_others();
  if (!list) throw Error("{}: has no [[region]]; see docs/materials.md", path);
  const std::vector<TomlTable> tables = list->tables();
  if (tables.size() > kMaxMaterialRegions)
    throw Error("{}: has {} regions, more than {}; join some with ids", list->where(), tables.size(),
                kMaxMaterialRegions);
  std::vector<MaterialRegion> regions;
  regions.reserve(tables.size());
  for (const TomlTable& table : tables) regions.push_back(read_region(table));
  return regions;
}

}  // namespace palpate
