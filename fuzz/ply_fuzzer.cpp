// Scene files: for any bytes, load_scene() either throws Error or returns a scene on which lint, filter,
// index and query agree; and read_ply_materials() returns a row for each of its Gaussians, or none.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <palpate/base/error.h>
#include <palpate/collision/scene_index.h>
#include <palpate/scene/lint.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/ply_materials.h>

#include "input_file.h"

namespace {

using palpate::fuzz::require;

void use(const palpate::GaussianScene& scene) {
  require(scene.size() > 0 && scene.id.size() == scene.size() && scene.scale.size() == scene.size());
  require(scene.rotation.size() == scene.size() && scene.opacity.size() == scene.size());
  require(scene.color.empty() || scene.color.size() == scene.size());
  require(scene.filter_3d.empty() || scene.filter_3d.size() == scene.size());

  const palpate::LintReport lint = palpate::lint(scene);
  palpate::FilterReport report;
  palpate::SceneFilter filter;
  filter.opacity_min = 0.0;
  const palpate::EllipsoidScene kept = palpate::filter_scene(scene, filter, {}, report);
  require(lint.total == scene.size() && report.total == scene.size());
  require(report.defective() + report.low_opacity + report.kept == scene.size());
  require(report.kept == kept.size() && lint.defects[0] >= kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    require(kept.ellipsoids[i].center.allFinite() && kept.ellipsoids[i].axes.allFinite());
    require(kept.opacity[i] > 0.0 && kept.opacity[i] <= 1.0);
  }
  if (kept.size() == 0) return;
  const palpate::Pose pose{kept.ellipsoids.front().center, Eigen::Quaterniond::Identity()};
  palpate::ContactSet contacts;
  const palpate::SceneIndex index(scene, filter, {});
  require(index.size() == kept.size());
  index.query(palpate::Ellipsoid::from_semi_axes(pose, {0.02, 0.02, 0.04}), contacts);
  require(!contacts.contacts.empty());  // the tool sits on the first Gaussian
  for (const palpate::Contact& c : contacts.contacts) {
    require(c.k_min > 0.0 && c.k_min <= 1.0 && std::isfinite(c.depth));
    require(c.point.allFinite() && std::abs(c.normal.norm() - 1.0) < 1e-9);
  }
}

void check(const palpate::PlyMaterials& materials, std::size_t rows) {
  for (std::size_t p = 0; p < palpate::kMaterialPropertyCount; ++p) {
    require(materials.values[p].empty() || materials.values[p].size() == rows);
    for (const float v : materials.values[p])
      require(std::isnan(v) || (v >= 0.0F && v <= palpate::kMaterialProperties[p].most));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file;
  for (const char* name : {"scene.ply", "scene.splat"}) {
    try {
      const palpate::GaussianScene scene = palpate::load_scene(file.hold(data, size, name));
      use(scene);
      check(palpate::read_ply_materials(scene.source), scene.size());
    } catch (const palpate::Error&) {
    }
  }
  return 0;
}
