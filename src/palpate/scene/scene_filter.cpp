#include <palpate/scene/scene_filter.h>

#include <cmath>
#include <numeric>

namespace palpate {
namespace {

/// Standard deviations out to which the Gaussian is solid.
double sigma_multiple(double opacity, const SceneFilter& filter) {
  return filter.iso ? std::sqrt(2.0 * std::log(opacity / *filter.iso)) : filter.sigma;
}

bool beyond_extent(const Ellipsoid& e) {
  return !(e.center.cwiseAbs().maxCoeff() <= kMaxExtent && e.radius() <= kMaxExtent);
}

bool outside_crop(const Eigen::Vector3d& center, const SceneFilter& filter) {
  if (filter.crop_box && !filter.crop_box->contains(center)) return true;
  return filter.crop_sphere && (center - filter.crop_sphere->center).norm() > filter.crop_sphere->radius;
}

}  // namespace

std::size_t FilterReport::defective() const {
  return std::accumulate(defects.begin(), defects.end(), std::size_t{0});
}

Ellipsoid world_ellipsoid(const Gaussian& gaussian, const SceneFilter& filter,
                          const Similarity& world_from_scene) {
  const double k = sigma_multiple(gaussian.opacity, filter) * world_from_scene.scale;
  const Eigen::Matrix3d R_world = (world_from_scene.rotation * gaussian.rotation).toRotationMatrix();
  return {world_from_scene * gaussian.position, R_world * (k * gaussian.sigma).asDiagonal()};
}

EllipsoidScene filter_scene(const GaussianScene& scene, const SceneFilter& filter,
                            const Similarity& world_from_scene, FilterReport& report,
                            const Progress& progress) {
  constexpr std::size_t kPerReport = 1 << 16;
  report = {};
  report.total = scene.size();
  EllipsoidScene kept;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (i % kPerReport == 0)
      palpate::report(progress, "filtering", static_cast<double>(i) / static_cast<double>(scene.size()));
    const Gaussian gaussian = scene.gaussian(i);
    if (const Defect d = defect(scene, i, gaussian); d != Defect::kNone) {
      ++report.defects[static_cast<std::size_t>(d)];
      continue;
    }
    if (!(gaussian.opacity > filter.opacity_min)) {
      ++report.low_opacity;
      continue;
    }
    if (filter.iso && !(gaussian.opacity > *filter.iso)) {
      ++report.below_iso;
      continue;
    }
    if (filter.max_scale && world_from_scene.scale * gaussian.sigma.maxCoeff() > *filter.max_scale) {
      ++report.over_max_scale;
      continue;
    }
    const Ellipsoid ellipsoid = world_ellipsoid(gaussian, filter, world_from_scene);
    if (beyond_extent(ellipsoid)) {
      ++report.defects[static_cast<std::size_t>(Defect::kInfinite)];
      continue;
    }
    if (outside_crop(ellipsoid.center, filter)) {
      ++report.outside_crop;
      continue;
    }
    kept.ellipsoids.push_back(ellipsoid);
    kept.opacity.push_back(gaussian.opacity);
    kept.id.push_back(scene.id[i]);
    if (!scene.color.empty()) kept.color.push_back(scene.color[i]);
  }
  report.kept = kept.size();
  palpate::report(progress, "filtering", 1.0);
  return kept;
}

}  // namespace palpate
