#include <palpate/study/seen_surface.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include <palpate/scene/scene_filter.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// Splatting draws nothing below the least alpha, and clamps at the largest.
constexpr double kLeastAlpha = 1.0 / 255.0, kMostAlpha = 0.99;
/// Distance at which an opaque Gaussian falls below kLeastAlpha, in standard deviations.
constexpr double kEnd = 3.33;
/// Assumed thickness of a Gaussian without one, as a fraction of its longest deviation.
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

std::optional<double> SeenSurface::depth(const Vector3d& from, const Vector3d& along, double left) const {
  return SeenRays(*this, from, along, 0.0).depth(from, left);
}

std::optional<double> SeenSurface::first_touch(const Tool& tool, const Vector3d& from,
                                               const Vector3d& along) const {
  return SeenRays(*this, from, along, tool.radius()).first_touch(tool);
}

SeenRays::SeenRays(const SeenSurface& scene, const Vector3d& from, const Vector3d& along, double radius)
    : from_(from), along_(along), u_(along.unitOrthogonal()), v_(along.cross(u_)) {
  for (const SeenSurface::Splat& splat : scene.splats_) {
    const Vector3d way = splat.center - from;
    const Eigen::Vector2d middle(way.dot(u_), way.dot(v_));
    const double reach = radius + splat.radius;
    if (middle.squaredNorm() >= reach * reach) continue;
    const Vector3d ray = splat.whitening * along, a = splat.whitening * u_, b = splat.whitening * v_;
    const double size = ray.norm();
    const Vector3d across_a = ray.cross(a) / size, across_b = ray.cross(b) / size;
    images_.push_back({middle, across_a.squaredNorm(), across_a.dot(across_b), across_b.squaredNorm(),
                       way.dot(along), -ray.dot(a) / (size * size), -ray.dot(b) / (size * size), splat.radius,
                       splat.opacity});
  }
}

std::optional<double> SeenRays::depth(const Vector3d& point, double left) const {
  const Eigen::Vector2d place((point - from_).dot(u_), (point - from_).dot(v_));
  std::vector<std::pair<double, double>> met;  // depth and alpha
  for (const Image& image : images_) {
    const Eigen::Vector2d way = place - image.middle;
    if (way.squaredNorm() >= image.radius * image.radius) continue;
    const double m2 =
        way.x() * way.x() * image.aa + 2.0 * way.x() * way.y() * image.ab + way.y() * way.y() * image.bb;
    const double alpha = std::min(kMostAlpha, image.opacity * std::exp(-0.5 * m2));
    const double depth = image.t + way.x() * image.tx + way.y() * image.ty;
    if (depth > 0.0 && alpha >= kLeastAlpha) met.emplace_back(depth, alpha);
  }
  std::ranges::sort(met);
  double transmittance = 1.0;
  for (const auto& [depth, alpha] : met) {
    transmittance *= 1.0 - alpha;
    if (transmittance < left) return depth;
  }
  return {};
}

std::optional<double> SeenRays::first_touch(const Tool& tool, const Vector3d& aside, int rings) const {
  // Rings are evenly spaced along the tool's surface, not across it: at the flank, where it is steep, a ray
  // that is a little farther out may meet a surface much nearer to the tool.
  constexpr double kSilhouette = 0.98;
  const double farthest = std::asin(kSilhouette);
  std::optional<double> first;
  for (const ToolPart& part : tool.parts()) {
    const Ellipsoid solid = part.at({});
    // Points of the disc across the ray in the coordinates in which the part is a unit sphere: the ray
    // through one leaves the solid where it leaves the sphere.
    const Vector3d w = (solid.axes.inverse() * along_).normalized(), p = w.unitOrthogonal(), q = w.cross(p);
    for (int ring = 0; ring <= rings; ++ring) {
      const int rays = ring == 0 ? 1 : 6 * ring;
      const double r = std::sin(farthest * ring / std::max(1, rings));
      for (int k = 0; k < rays; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / rays;
        const Vector3d lowest =
            solid.axes * (r * std::cos(angle) * p + r * std::sin(angle) * q + std::sqrt(1.0 - r * r) * w);
        const Vector3d point = solid.center + lowest;  // of the tool, at the origin
        const std::optional<double> seen = depth(from_ + aside + point);
        if (seen && (!first || *seen - point.dot(along_) < *first)) first = *seen - point.dot(along_);
      }
    }
  }
  return first;
}

}  // namespace palpate
