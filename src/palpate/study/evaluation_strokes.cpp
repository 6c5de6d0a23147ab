#include <palpate/study/evaluation_strokes.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kShallowest = 0.004;   // least depth at which presses are judged. [m]
constexpr double kDeepest = 1.5;        // depth of a press, in extents of the tool
constexpr double kStrokeLength = 0.03;  // [m]
constexpr int kSettleTicks = 50;        // ticks until filters have settled
constexpr double kDegree = std::numbers::pi / 180.0;

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

CurveBins over_depth(const Tool& tool) {
  constexpr std::size_t kDepthBins = 30;
  return {0.0, kDeepest * tool.thinnest(), kDepthBins};
}

}  // namespace

Presses::Presses(const EvaluationSetup& setup)
    : stiffness_(setup.stiffness), direction_at_(over_depth(setup.tool)), force_at_(over_depth(setup.tool)) {}

void Presses::at(Hand& hand, const SurfaceSample& place, const SeenSurface& scene) {
  const double r = reach(hand.tool(), place.normal);
  const auto way = scene.first_touch(hand.tool(), centre_at(place, hand.tool(), -r), -place.normal);
  const double seen = way ? *way - r : std::numeric_limits<double>::quiet_NaN();
  if (way) seen_.push_back(seen);
  bool touched = false;
  hand.reset();
  const auto feel = [&](const ForceOutput& felt, double s) {
    const Vector3d& force = felt.wrench.force;
    const double depth = s - r, size = force.norm(), off = degrees_between(force, place.normal);
    if (!touched && size > 0.0) onset_.push_back(depth);
    touched = touched || size > 0.0;
    force_at_.add(depth, size);
    if (size > 0.0) direction_at_.add(depth, off);
    if (depth < kShallowest) return;
    if (size == 0.0) {
      ++silent_;
      return;
    }
    direction_.push_back(off);
    if (force.dot(place.normal) < 0.0) ++flipped_;
    if (stiffness_ > 0.0) {
      magnitude_.push_back(size / (stiffness_ * depth));
      if (depth > seen) magnitude_seen_.push_back(size / (stiffness_ * (depth - seen)));
    }
  };
  hand.move(centre_at(place, hand.tool(), -r), centre_at(place, hand.tool(), kDeepest * r), kHandSpeed, feel);
}

void Presses::tell(Evaluation& result) const {
  result.direction = spread_of(direction_);
  result.magnitude = spread_of(magnitude_);
  result.magnitude_seen = spread_of(magnitude_seen_);
  result.seen = spread_of(seen_);
  result.silent = silent_;
  result.flipped = flipped_;
  result.onset = spread_of(onset_);
  result.direction_at = direction_at_.curve();
  result.force_at = force_at_.curve();
}

void Slides::at(Hand& hand, const SurfaceSample& start) {
  const double r = reach(hand.tool(), start.normal), depth = 0.5 * r;
  hand.come_down(start, depth);
  ForceOutput felt;
  for (int tick = 0; tick < kSettleTicks; ++tick) felt = hand.at(centre_at(start, hand.tool(), depth));
  held_.push_back(felt.wrench.force.norm());
  std::vector<Vector3d> forces;
  SurfaceSample place = start;
  for (int tick = 0; tick < ticks_on(kStrokeLength); ++tick) {
    place = next_place(surface_, place, kHandStep);
    if (!tool_fits(surface_, place, hand.tool()) || !is_smooth(surface_, place, r)) break;
    forces.push_back(hand.at(centre_at(place, hand.tool(), depth)).wrench.force);
  }
  judge(forces, depth);
}

void Slides::judge(const std::vector<Vector3d>& forces, double depth) {
  constexpr std::size_t kFewest = 100;
  double sum = 0.0, squares = 0.0, jump = 0.0;
  for (std::size_t k = 0; k < forces.size(); ++k) {
    sum += forces[k].norm();
    squares += forces[k].squaredNorm();
    if (k > 0) jump = std::max(jump, (forces[k] - forces[k - 1]).norm());
  }
  if (forces.size() < kFewest || sum == 0.0) return;
  const auto count = static_cast<double>(forces.size());
  const double mean = sum / count;
  ripple_.push_back(std::sqrt(std::max(0.0, squares / count - mean * mean)) / mean);
  jump_.push_back(jump);
  if (!first_.empty()) return;
  first_depth_ = depth;
  for (std::size_t k = 0; k < forces.size(); ++k)
    first_.emplace_back(static_cast<double>(k + 1) * kHandStep, forces[k].norm());
}

void Slides::tell(Evaluation& result) const {
  result.held = held_;
  result.ripple = spread_of(ripple_);
  result.jump = spread_of(jump_);
  result.slide = first_;
  result.slide_depth = first_depth_;
}

void Loops::at(Hand& hand, const SurfaceSample& place) {
  if (!(stiffness_ > 0.0)) return;
  const double r = reach(hand.tool(), place.normal), depth = 0.25 * r, radius = 0.25 * r;
  const Vector3d center = centre_at(place, hand.tool(), depth), other = place.normal.cross(place.tangent);
  const int ticks = static_cast<int>(2.0 * std::numbers::pi * radius / (kHandSpeed * kTick));
  const auto point = [&](int k) {
    const double angle = 2.0 * std::numbers::pi * k / ticks;
    return Vector3d(center + radius * (std::cos(angle) * place.tangent + std::sin(angle) * other));
  };
  hand.reset();
  hand.move(point(0) + 2.0 * r * place.normal, point(0), kHandSpeed, [](const ForceOutput&, double) {});
  // The model settles in the first turn; the second counts.
  double work = 0.0;
  Vector3d last = hand.at(point(0)).wrench.force;
  for (int k = 1; k <= 2 * ticks; ++k) {
    const Vector3d force = hand.at(point(k)).wrench.force;
    if (k > ticks) work += 0.5 * (force + last).dot(point(k) - point(k - 1));
    last = force;
  }
  loop_.push_back(std::abs(work) / (0.5 * stiffness_ * depth * depth));
}

}  // namespace palpate
