#include <palpate/haptics/seen_surface.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include <palpate/scene/scene_filter.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// What splatting does not draw.
constexpr double kLeastAlpha = 1.0 / 255.0, kMostAlpha = 0.99, kHalf = 0.5;
/// Where an opaque Gaussian falls below kLeastAlpha, in standard deviations.
constexpr double kEnd = 3.33;
/// A Gaussian of no thickness has this one, of its longest deviation.
constexpr double kLeastThickness = 1e-6;

}  // namespace

SeenSurface::SeenSurface(const GaussianScene& scene, const Similarity& world_from_scene) {
  SceneFilter all;
  all.opacity_min = 0.0;
  FilterReport report;
  const EllipsoidScene ellipsoids = filter_scene(scene, all, world_from_scene, report);
  splats_.reserve(ellipsoids.size());
  for (std::size_t i = 0; i < ellipsoids.size(); ++i) {
    const Ellipsoid& e = ellipsoids.ellipsoids[i];
    const double longest = e.radius();
    Splat splat{e.center, {}, kEnd * longest, ellipsoids.opacity[i]};
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double length = e.axes.col(k).norm();
      const Vector3d direction =
          length > 0.0 ? Vector3d(e.axes.col(k) / length)
                       : Vector3d(e.axes.col((k + 1) % 3).cross(e.axes.col((k + 2) % 3)).normalized());
      splat.whitening.row(k) = direction.transpose() / std::max(length, kLeastThickness * longest);
    }
    splats_.push_back(splat);
  }
}

SeenSurface::Splats SeenSurface::near(const Vector3d& from, const Vector3d& along, double radius) const {
  Splats found;
  for (const Splat& splat : splats_) {
    const Vector3d way = splat.center - from;
    const double reach = radius + splat.radius;
    if (way.squaredNorm() - std::pow(way.dot(along), 2) < reach * reach) found.push_back(&splat);
  }
  return found;
}

std::optional<double> SeenSurface::composite(const Splats& splats, const Vector3d& from,
                                             const Vector3d& along) {
  std::vector<std::pair<double, double>> met;  // depth and alpha
  for (const Splat* splat : splats) {
    const Vector3d ray = splat->whitening * along, way = splat->whitening * (splat->center - from);
    const double depth = ray.dot(way) / ray.squaredNorm();
    const double m2 = ray.cross(way).squaredNorm() / ray.squaredNorm();
    const double alpha = std::min(kMostAlpha, splat->opacity * std::exp(-0.5 * m2));
    if (depth > 0.0 && alpha >= kLeastAlpha) met.emplace_back(depth, alpha);
  }
  std::ranges::sort(met);
  double transmittance = 1.0;
  for (const auto& [depth, alpha] : met) {
    transmittance *= 1.0 - alpha;
    if (transmittance < kHalf) return depth;
  }
  return {};
}

std::optional<double> SeenSurface::depth(const Vector3d& from, const Vector3d& along) const {
  return composite(near(from, along, 0.0), from, along);
}

std::optional<double> SeenSurface::first_touch(const Tool& tool, const Vector3d& from,
                                               const Vector3d& along) const {
  constexpr double kSilhouette = 0.98;
  const Splats splats = near(from, along, tool.radius());
  const Vector3d u = along.unitOrthogonal(), v = along.cross(u);
  std::optional<double> first;
  for (const ToolPart& part : tool.parts()) {
    const Ellipsoid solid = part.at({});
    for (int ring = 0; ring <= kRings; ++ring) {
      const int rays = ring == 0 ? 1 : 6 * ring;
      for (int k = 0; k < rays; ++k) {
        // A point of the unit sphere's disc across the ray, as the part's own axes see it: the ray through it
        // leaves the solid where the sphere ends.
        const Eigen::Matrix3d inverse = solid.axes.inverse();
        const Vector3d w = (inverse * along).normalized(), p = w.unitOrthogonal(), q = w.cross(p);
        const double r = kSilhouette * ring / kRings, angle = 2.0 * std::numbers::pi * k / rays;
        const Vector3d lowest =
            solid.axes * (r * std::cos(angle) * p + r * std::sin(angle) * q + std::sqrt(1.0 - r * r) * w);
        const Vector3d point = solid.center + lowest;  // of the tool, at the origin
        const Vector3d aside = point.dot(u) * u + point.dot(v) * v;
        const std::optional<double> seen = composite(splats, from + aside, along);
        if (seen && (!first || *seen - point.dot(along) < *first)) first = *seen - point.dot(along);
      }
    }
  }
  return first;
}

}  // namespace palpate
