// Scene files: whatever the bytes, load_scene() either throws Error or gives a scene that lint, filter,
// index and query agree about.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <palpate/base/error.h>
#include <palpate/collision/scene_index.h>
#include <palpate/scene/lint.h>
#include <palpate/scene/load_scene.h>

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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file;
  for (const char* name : {"scene.ply", "scene.splat"}) {
    try {
      use(palpate::load_scene(file.hold(data, size, name)));
    } catch (const palpate::Error&) {
    }
  }
  return 0;
}
