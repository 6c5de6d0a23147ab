#include <palpate/study/evaluation_hand.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include <palpate/geometry/solids.h>

namespace palpate {

using Eigen::Vector3d;

Tool ball(double radius) { return Tool(Vector3d::Constant(radius)); }

Vector3d random_direction(Random& random) {
  for (;;) {
    const double z = random.normal(), y = random.normal(), x = random.normal();
    const Vector3d v(x, y, z);
    if (v.norm() > 1e-3) return v.normalized();
  }
}

Vector3d even_direction(int k, int count) {
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  const double z = 1.0 - (2.0 * k + 1.0) / count, r = std::sqrt(1.0 - z * z);
  return {r * std::cos(golden * k), r * std::sin(golden * k), z};
}

double share_of(std::size_t part, std::size_t all) {
  return all == 0 ? std::numeric_limits<double>::quiet_NaN()
                  : static_cast<double>(part) / static_cast<double>(all);
}

double reach(const Tool& tool, const Vector3d& n) { return tool.support(-n); }

Vector3d centre_at(const SurfaceSample& place, const Tool& tool, double depth) {
  Vector3d foot = Vector3d::Zero();
  for (const ToolPart& part : tool.parts()) {
    const Ellipsoid solid = part.at({});
    const Vector3d lowest = farthest_point(solid, -place.normal);
    if (&part == tool.parts().data() || lowest.dot(place.normal) < foot.dot(place.normal)) foot = lowest;
  }
  return place.point - depth * place.normal - foot;
}

GaussianScene gaussians_of(const AnalyticSurface& surface, const EvaluationSetup& setup, std::size_t k) {
  ProceduralOptions options = setup.scene;
  options.seed += k;
  return make_scene(surface, options);
}

SceneIndex scene_of(const AnalyticSurface& surface, const EvaluationSetup& setup, std::size_t k) {
  return {gaussians_of(surface, setup, k), SceneFilter{}, Similarity{}};
}

void Hand::reset() {
  model_->reset();
  moving_ = false;
}

ForceOutput Hand::at(const Vector3d& position) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const Pose pose{position, Eigen::Quaterniond::Identity()};
  if (model_->wants_contacts()) tracker_.query(pose, contacts_);
  Twist velocity;
  if (moving_) velocity.linear = (position - last_) / kTick;
  ForceOutput felt = model_->evaluate({pose, velocity, moving_ ? kTick : 0.0, &contacts_});
  const double us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  if (felt.wrench.force.squaredNorm() > 0.0) ticks_.push_back(us);
  last_ = position;
  moving_ = true;
  return felt;
}

void Hand::come_down(const SurfaceSample& place, double depth) {
  reset();
  move(centre_at(place, tool_, -reach(tool_, place.normal)), centre_at(place, tool_, depth), kHandSpeed,
       [](const ForceOutput&, double) {});
}

SurfaceSample next_place(const AnalyticSurface& surface, const SurfaceSample& place, double step) {
  constexpr double kAbove = 10.0;  // in steps, so that the side of the surface is unambiguous
  const NearestPoint there = surface.project(place.point + step * (place.tangent + kAbove * place.normal));
  const Vector3d tangent = place.tangent - there.normal.dot(place.tangent) * there.normal;
  return {there.point, there.normal, tangent.normalized(), place.spacing};
}

bool tool_fits(const AnalyticSurface& surface, const SurfaceSample& place, const Tool& tool) {
  constexpr double kRounding = 1e-4;  // [m]
  const double radius = tool.radius();
  return surface.distance(place.point + (radius + kRounding) * place.normal) >= radius;
}

namespace {

/// Returns true if `accept(probe, nearest)` holds for all probes, points `above` a circle about `place`, and
/// none is beyond a border. From above, an edge is seen from both of its sides.
template <class Accept>
bool all_around(const AnalyticSurface& surface, const SurfaceSample& place, double radius, double above,
                const Accept& accept) {
  constexpr int kProbes = 16;
  const Vector3d other = place.normal.cross(place.tangent);
  for (int k = 0; k < kProbes; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kProbes;
    const Vector3d probe = place.point + above * place.normal +
                           radius * (std::cos(angle) * place.tangent + std::sin(angle) * other);
    const NearestPoint there = surface.project(probe);
    // Beyond a border, the nearest point is on the border.
    if ((there.point - place.point).norm() < 0.7 * radius || !accept(probe, there)) return false;
  }
  return true;
}

constexpr double kAbove = 0.1;  // as a fraction of the margin

}  // namespace

bool is_inland(const AnalyticSurface& surface, const SurfaceSample& place, double margin) {
  return all_around(surface, place, margin, kAbove * margin,
                    [](const Vector3d&, const NearestPoint&) { return true; });
}

bool is_smooth(const AnalyticSurface& surface, const SurfaceSample& place, double margin) {
  constexpr int kRings = 6;
  const auto goes_on = [&](const Vector3d& probe, const NearestPoint& there) {
    // The nearest point is straight below, except at the border of a part of the surface.
    const double aside = (probe - there.point).cross(there.normal).norm();
    return there.normal.dot(place.normal) > 0.7 && aside < 1e-6 * margin;
  };
  for (int ring = 1; ring <= kRings; ++ring) {
    if (!all_around(surface, place, margin * ring / kRings, kAbove * margin, goes_on)) return false;
  }
  return true;
}

}  // namespace palpate
