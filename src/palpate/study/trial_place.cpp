#include <palpate/study/trial_place.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <palpate/geometry/solids.h>
#include <palpate/study/evaluation_hand.h>
#include <palpate/study/trial_tools.h>

namespace palpate {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

/// Spacing as a fraction of the tool's shortest semi-axis, and its bounds. [m]
constexpr double kSpacingOfTool = 1.0 / 3.0, kFinest = 0.0005, kCoarsest = 0.006;
const Vector3d kBox(0.3, 0.2, 0.16);   // [m]
constexpr double kMostSplats = 1.5e5;  // limit on a box, unless it gets too small for the tool
constexpr double kBeside = 0.01;       // margin beside a tool on a face. [m]
constexpr double kNearEdge = 0.003;    // largest offset of an aim from an edge, corner or rim. [m]
constexpr double kOblique = 20.0, kObliqueAtEdge = 45.0, kTipOff = 10.0;  // largest angles. [deg]
constexpr double kWider = 1.15, kNarrower = 0.85;                         // of a hole, relative to the tool

/// Draws a direction within `most` degrees of `middle`, uniformly distributed.
Vector3d within_cone(const Vector3d& middle, double most, Random& random) {
  const double c = random.uniform(std::cos(most * pi / 180.0), 1.0), s = std::sqrt(1.0 - c * c);
  const double angle = random.uniform(0.0, 2.0 * pi);
  const Vector3d u = middle.unitOrthogonal(), v = middle.cross(u);
  return c * middle + s * (std::cos(angle) * u + std::sin(angle) * v);
}

Quaterniond random_turn(Random& random) {
  const Vector3d axis = random_direction(random);
  return Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis) *
         Quaterniond(Eigen::AngleAxisd(random.uniform(0.0, 2.0 * pi), Vector3d::UnitZ()));
}

/// Half the width of a tool in a hole: its middle semi-axis, or half the radius of a tool with several parts.
double middle_of(const Tool& tool) {
  if (tool.parts().size() > 1) return 0.5 * tool.radius();
  Vector3d a = tool.parts().front().semi_axes;
  std::ranges::sort(a);
  return a[1];
}

}  // namespace

TrialPlace::TrialPlace(const std::string& name, const Tool& tool, std::size_t variant)
    : name_(name), tool_(tool), spacing_(std::clamp(kSpacingOfTool * tool.thinnest(), kFinest, kCoarsest)) {
  const bool first = variant % 2 == 0;
  if (name == "plate") {
    make_slab((first ? 1.0 : 2.0) * tool.thinnest());
  } else if (name == "sheet") {
    make_slab(0.0);
  } else if (name == "hole") {
    make_hole(first);
  } else {
    make_box();
  }
}

void TrialPlace::own(std::unique_ptr<AnalyticShape> shape) {
  std::vector<SurfacePart> parts;
  parts.push_back({name_, {176, 176, 184}, {}, std::move(shape)});
  surface_ = std::make_unique<AnalyticSurface>(name_, spacing_, std::move(parts));
}

void TrialPlace::make_box() {
  const double area = 2.0 * (kBox[0] * kBox[1] + kBox[1] * kBox[2] + kBox[2] * kBox[0]);
  const double fewest = std::sqrt(kMostSplats * spacing_ * spacing_ / area);
  const double size = std::max(std::min(1.0, fewest), 2.0 * (tool_.radius() + kBeside) / kBox[1]);
  half_ = 0.5 * size * kBox;
  own(palpate::make_box(2.0 * half_));
}

// Wide enough that the nearest way out is never around the border.
void TrialPlace::make_slab(double thickness) {
  const double aside = kDeepestTrial * (1.0 + std::tan(kOblique * pi / 180.0)) + 2.0 * kBeside;
  const double width = 2.0 * (tool_.radius() + aside);
  thickness_ = thickness;
  half_ = {0.5 * width, 0.5 * width, 0.5 * thickness};
  own(thickness > 0.0 ? palpate::make_box(2.0 * half_) : make_rectangle(width, width));
}

void TrialPlace::make_hole(bool wider) {
  const double hole = (wider ? kWider : kNarrower) * middle_of(tool_);
  minor_ = std::max(0.01, 2.0 * tool_.thinnest());
  major_ = hole + minor_;
  own(make_torus(major_, minor_));
}

Vector3d TrialPlace::point_at(Random& random, Vector3d& normal) const {
  const double near = std::min(kNearEdge, tool_.thinnest());
  const Vector3d off = near * random_direction(random);
  normal = Vector3d::UnitZ();
  if (name_ == "hole") {
    const double angle = random.uniform(0.0, 2.0 * pi);
    return (major_ - minor_) * Vector3d(std::cos(angle), std::sin(angle), 0.0) + off;
  }
  if (name_ == "corner") {
    normal = Vector3d::Constant(std::sqrt(1.0 / 3.0));
    return half_ + off;
  }
  // On the face towards +z: inside it, or at one of its long edges.
  const auto within = [&](double half) {
    const double free = thickness_ ? kBeside : std::max(0.0, half - tool_.radius() - 0.5 * kBeside);
    return random.uniform(-free, free);
  };
  const double x = within(half_[0]), y = within(half_[1]);
  if (name_ != "edge") return {x, y, half_[2]};
  normal = Vector3d(0.0, 1.0, 1.0).normalized();
  return Vector3d(x, half_[1], half_[2]) + off;
}

TrialAim TrialPlace::aim(Random& random, bool tip_first) const {
  TrialAim aim{{}, {}, {}, tool_};
  aim.point = point_at(random, aim.normal);
  const bool sharp = name_ == "edge" || name_ == "corner";
  aim.along = within_cone(-aim.normal, sharp ? kObliqueAtEdge : kOblique, random);
  const Quaterniond turn = random_turn(random);
  if (!tip_first) {
    aim.tool = turned(tool_, turn);
  } else {
    const Vector3d tip = within_cone(aim.along, kTipOff, random);
    aim.tool = turned(tool_, Quaterniond::FromTwoVectors(Vector3d::UnitZ(), tip));
  }
  return aim;
}

double deepest(const AnalyticSurface& surface, const Tool& tool, const Pose& pose) {
  constexpr int kDirections = 48;
  static const std::vector<Vector3d> directions = [] {
    std::vector<Vector3d> all{Vector3d::Zero()};
    for (int k = 0; k < kDirections; ++k) all.push_back(even_direction(k, kDirections));
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (const double share : {0.25, 0.5, 0.75, 1.0}) {
        all.emplace_back(share * Vector3d::Unit(k));
        all.emplace_back(-share * Vector3d::Unit(k));
      }
    }
    return all;
  }();
  constexpr int kRefinements = 3;
  double most = -std::numeric_limits<double>::infinity();
  for (const ToolPart& part : tool.parts()) {
    const Ellipsoid solid = part.at(pose);
    const double above = surface.distance(solid.center);
    if (-above + solid.radius() <= most) continue;
    double best = -std::numeric_limits<double>::infinity();
    Vector3d at = solid.center;
    const auto look = [&](const Vector3d& point) {
      const double depth = -surface.distance(point);
      if (depth <= best) return false;
      best = depth;
      at = point;
      return true;
    };
    for (const Vector3d& u : directions) look(solid.center + solid.axes * u);
    for (int k = 0; k < kRefinements; ++k) {
      if (!look(farthest_point(solid, -surface.project(at).normal))) break;
    }
    most = std::max(most, best);
  }
  return most;
}

}  // namespace palpate
