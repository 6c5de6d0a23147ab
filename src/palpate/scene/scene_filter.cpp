#include <palpate/scene/scene_filter.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include <palpate/base/append.h>
#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/geometry/unit_quaternion.h>

namespace palpate {
namespace {

/// Number of Gaussians in a block, which one thread filters at a time.
constexpr std::size_t kBlock = std::size_t{1} << 12;
/// Number of blocks that are filtered before their results are collected: limits duplicated data to 30 MB.
constexpr std::size_t kBlocksPerRound = 64;

void require_in(std::string_view member, double value, double least, double most) {
  if (!(value >= least && value <= most))
    throw Error("{} is {}; set it to a number from {} to {}", member, value, least, most);
}

void require(bool good, std::string_view member, std::string_view must_be) {
  if (!good) throw Error("{} is not {}; correct it", member, must_be);
}

bool beyond_extent(const Ellipsoid& e) {
  return !(e.center.cwiseAbs().maxCoeff() <= kMaxExtent && e.radius() <= kMaxExtent);
}

bool outside_crop(const Eigen::Vector3d& center, const SceneFilter& filter) {
  if (filter.crop_box && !filter.crop_box->contains(center)) return true;
  return filter.crop_sphere && (center - filter.crop_sphere->center).norm() > filter.crop_sphere->radius;
}

/// As keeps(), but returns the ellipsoid of a Gaussian that is kept.
std::optional<Ellipsoid> kept_ellipsoid(const GaussianScene& scene, std::size_t i, const Gaussian& activated,
                                        const SceneFilter& filter, const Similarity& world_from_scene,
                                        FilterReport& report) {
  const auto drop = [](std::size_t& count) {
    ++count;
    return std::nullopt;
  };
  ++report.total;
  if (const Defect d = defect(scene, i, activated); d != Defect::kNone)
    return drop(report.defects[static_cast<std::size_t>(d)]);
  if (!(activated.opacity > filter.opacity_min)) return drop(report.low_opacity);
  if (filter.iso && !(activated.opacity > *filter.iso)) return drop(report.below_iso);
  if (filter.max_scale && world_from_scene.scale * activated.sigma.maxCoeff() > *filter.max_scale)
    return drop(report.over_max_scale);
  const Ellipsoid ellipsoid = world_ellipsoid(activated, filter, world_from_scene);
  if (beyond_extent(ellipsoid)) return drop(report.defects[static_cast<std::size_t>(Defect::kInfinite)]);
  if (outside_crop(ellipsoid.center, filter)) return drop(report.outside_crop);
  ++report.kept;
  return ellipsoid;
}

struct FilteredBlock {
  EllipsoidScene kept;
  FilterReport report;
};

/// Reserves memory for all at once: growing would copy, and pages that stay unused are never touched.
void reserve(EllipsoidScene& scene, std::size_t n) {
  scene.ellipsoids.reserve(n);
  scene.opacity.reserve(n);
  scene.id.reserve(n);
  scene.color.reserve(n);
}

void append(EllipsoidScene& scene, const EllipsoidScene& part) {
  palpate::append(scene.ellipsoids, part.ellipsoids);
  palpate::append(scene.opacity, part.opacity);
  palpate::append(scene.id, part.id);
  palpate::append(scene.color, part.color);
}

void clear(EllipsoidScene& scene) {
  scene.ellipsoids.clear();
  scene.opacity.clear();
  scene.id.clear();
  scene.color.clear();
}

/// Filters the Gaussians begin ... end-1 into `block`.
void filter_block(const GaussianScene& scene, std::size_t begin, std::size_t end, const SceneFilter& filter,
                  const Similarity& world_from_scene, FilteredBlock& block) {
  clear(block.kept);  // retains the capacity
  block.report = {};
  for (std::size_t i = begin; i < end; ++i) {
    const Gaussian gaussian = scene.gaussian(i);
    const auto ellipsoid = kept_ellipsoid(scene, i, gaussian, filter, world_from_scene, block.report);
    if (!ellipsoid) continue;
    block.kept.ellipsoids.push_back(*ellipsoid);
    block.kept.opacity.push_back(gaussian.opacity);
    block.kept.id.push_back(scene.id[i]);
    if (!scene.color.empty()) block.kept.color.push_back(scene.color[i]);
  }
}

}  // namespace

void check_filter(const SceneFilter& filter, const Similarity& world_from_scene) {
  require_in("SceneFilter::opacity_min", filter.opacity_min, 0.0, 1.0);
  require_in("SceneFilter::sigma", filter.sigma, SceneFilter::kSigmaMin, SceneFilter::kSigmaMax);
  require(!filter.iso || (*filter.iso > 0.0 && *filter.iso < 1.0), "SceneFilter::iso", "between 0 and 1");
  require(!filter.max_scale || *filter.max_scale > 0.0, "SceneFilter::max_scale", "positive");
  require(!filter.crop_box || (filter.crop_box->min().array() <= filter.crop_box->max().array()).all(),
          "SceneFilter::crop_box", "a box whose first corner is below the second");
  require(!filter.crop_sphere || (filter.crop_sphere->center.allFinite() && filter.crop_sphere->radius > 0.0),
          "SceneFilter::crop_sphere", "a finite centre with a positive radius");
  require_in("Similarity::scale", world_from_scene.scale, Similarity::kScaleMin, Similarity::kScaleMax);
  require(has_unit_norm(world_from_scene.rotation), "Similarity::rotation", "a unit quaternion");
  require(world_from_scene.translation.allFinite(), "Similarity::translation", "finite");
}

bool SceneFilter::operator==(const SceneFilter& other) const {
  // Eigen::AlignedBox has no operator==.
  const auto corners = [](const SceneFilter& f) {
    using Corners = std::pair<Eigen::Vector3d, Eigen::Vector3d>;
    return f.crop_box ? std::optional(Corners(f.crop_box->min(), f.crop_box->max())) : std::nullopt;
  };
  return opacity_min == other.opacity_min && sigma == other.sigma && iso == other.iso &&
         max_scale == other.max_scale && crop_sphere == other.crop_sphere && corners(*this) == corners(other);
}

std::size_t FilterReport::defective() const {
  return std::accumulate(defects.begin(), defects.end(), std::size_t{0});
}

FilterReport& operator+=(FilterReport& sum, const FilterReport& part) {
  sum.total += part.total;
  for (std::size_t d = 0; d < kDefectCount; ++d) sum.defects[d] += part.defects[d];
  sum.low_opacity += part.low_opacity;
  sum.below_iso += part.below_iso;
  sum.over_max_scale += part.over_max_scale;
  sum.outside_crop += part.outside_crop;
  sum.kept += part.kept;
  return sum;
}

double sigma_multiple(double opacity, const SceneFilter& filter) {
  return filter.iso ? std::sqrt(2.0 * std::log(opacity / *filter.iso)) : filter.sigma;
}

Ellipsoid world_ellipsoid(const Gaussian& gaussian, const SceneFilter& filter,
                          const Similarity& world_from_scene) {
  const double k = sigma_multiple(gaussian.opacity, filter) * world_from_scene.scale;
  const Eigen::Matrix3d Q_world = world_from_scene.orthogonal() * gaussian.rotation.toRotationMatrix();
  return {world_from_scene * gaussian.position, Q_world * (k * gaussian.sigma).asDiagonal()};
}

bool keeps(const GaussianScene& scene, std::size_t i, const Gaussian& activated, const SceneFilter& filter,
           const Similarity& world_from_scene, FilterReport& report) {
  return kept_ellipsoid(scene, i, activated, filter, world_from_scene, report).has_value();
}

Eigen::AlignedBox3d central_box(const EllipsoidScene& scene) {
  constexpr double kTail = 0.01;  // fraction of the centres on each side
  Eigen::Vector3d low, high;
  std::vector<double> values(scene.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(scene.ellipsoids, values.begin(),
                           [&](const Ellipsoid& e) { return e.center[axis]; });
    low[axis] = quantile(values, kTail);
    high[axis] = quantile(values, 1.0 - kTail);
  }
  return {low, high};
}

EllipsoidScene filter_scene(const GaussianScene& scene, const SceneFilter& filter,
                            const Similarity& world_from_scene, FilterReport& report,
                            const Progress& progress) {
  report = {};
  EllipsoidScene kept;
  reserve(kept, scene.size());
  std::vector<FilteredBlock> blocks(kBlocksPerRound);
  constexpr std::size_t kRound = kBlock * kBlocksPerRound;
  for (std::size_t first = 0; first < scene.size(); first += kRound) {
    palpate::report(progress, "filtering", static_cast<double>(first) / static_cast<double>(scene.size()));
    tbb::parallel_for(std::size_t{0}, kBlocksPerRound, [&](std::size_t b) {
      const std::size_t begin = std::min(first + b * kBlock, scene.size());
      const std::size_t end = std::min(begin + kBlock, scene.size());
      filter_block(scene, begin, end, filter, world_from_scene, blocks[b]);
    });
    for (const FilteredBlock& block : blocks) {
      report += block.report;
      append(kept, block.kept);
    }
  }
  palpate::report(progress, "filtering", 1.0);
  return kept;
}

}  // namespace palpate
