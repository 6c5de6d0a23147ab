#include <palpate/study/crossings.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include <palpate/study/evaluation_hand.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kHalfWay = 0.04;  // half the length of a crossing. [m]
constexpr std::size_t kBins = 160;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Centres of the proxy, tick by tick; empty for a model without a proxy.
using Path = std::vector<Vector3d>;

/// Crosses each of the setup's scenes in turn; `cross(hand, random)` crosses once and returns the path.
template <class Cross, class Judge>
void cross_all(const AnalyticSurface& surface, const EvaluationSetup& setup, const Tool& tool,
               const Cross& cross, const Judge& judge) {
  Random random(setup.seed);
  for (std::size_t k = 0; k < setup.scenes; ++k) {
    const SceneIndex index = scene_of(surface, setup, k);
    Hand hand(index, tool, setup.model);
    for (std::size_t i = k; i < setup.places; i += setup.scenes) {
      const Path path = cross(hand, random);
      if (!path.empty()) judge(path);
    }
  }
}

/// Moves the tool along `centres`; returns an empty path for a model whose proxy is the tool.
Path follow(Hand& hand, const Path& centres) {
  Path path;
  bool has_proxy = false;
  for (const Vector3d& centre : centres) {
    path.push_back(hand.at(centre).proxy.position);
    has_proxy = has_proxy || (path.back() - centre).norm() > 0.0;
  }
  return has_proxy ? path : Path{};
}

/// Distance over which the height rises from a tenth to nine tenths of its total rise. Unit: [m].
double rise_over(const Path& path) {
  const double low = path.front().z(), rise = path.back().z() - low;
  const auto first_above = [&](double part) {
    return std::find_if(path.begin(), path.end(),
                        [&](const Vector3d& p) { return p.z() > low + part * rise; });
  };
  return kHandStep * static_cast<double>(first_above(0.9) - first_above(0.1));
}

double largest_rise(const Path& path, std::size_t window) {
  double most = 0.0;
  for (std::size_t k = 0; k + window < path.size(); ++k)
    most = std::max(most, path[k + window].z() - path[k].z());
  return most;
}

}  // namespace

double step_truth(double way) {
  const double r = StepResponse::kBall, h = StepResponse::kHeight;
  const double first_touch = std::sqrt(r * r - (r - h) * (r - h));
  if (way < -first_touch) return r;
  return way < 0.0 ? h + std::sqrt(r * r - way * way) : h + r;
}

StepResponse step_response(const EvaluationSetup& setup) {
  const auto surface = make_surface("step");
  std::vector<double> felt, rises;
  CurveBins path_bins(-kHalfWay, kHalfWay, kBins);
  const auto cross = [](Hand& hand, Random& random) {
    const double y = random.uniform(-0.1, 0.1);
    const SurfaceSample start{{-kHalfWay, y, 0.0}, Vector3d::UnitZ(), Vector3d::UnitX(), 0.0};
    hand.come_down(start, StepResponse::kBall);
    Path centres;
    for (int k = 0; k < ticks_on(2.0 * kHalfWay); ++k) centres.emplace_back(k * kHandStep - kHalfWay, y, 0.0);
    return follow(hand, centres);
  };
  cross_all(*surface, setup, ball(StepResponse::kBall), cross, [&](const Path& path) {
    felt.push_back(largest_rise(path, static_cast<std::size_t>(StepResponse::kTravel / kHandStep)));
    rises.push_back(rise_over(path));
    for (const Vector3d& p : path) path_bins.add(p.x(), p.z());
  });
  return {spread_of(felt), spread_of(rises), path_bins.curve()};
}

namespace {

/// The edge at the +x and +z side of `box`, which runs along y. Lengths in [m].
class Edge {
 public:
  explicit Edge(double radius) : radius_(radius) {}

  /// Centres of a ball that moves around it at constant `depth`.
  Path around(double y, double depth) const {
    const double r = radius_ - depth, turn = 0.5 * std::numbers::pi * r;
    Path centres;
    for (int k = 0; k < ticks_on(turn + 2.0 * kHalfWay); ++k) {
      const double s = k * kHandStep - kHalfWay;
      const double angle = std::clamp(s / r, 0.0, 0.5 * std::numbers::pi);
      const double before = std::min(s, 0.0), after = std::max(s - turn, 0.0);
      centres.emplace_back(kX + before + r * std::sin(angle), y, kZ - after + r * std::cos(angle));
    }
    return centres;
  }

  /// Position of `centre` along the path of a rolling ball's centre, from the middle of its turn.
  double way(const Vector3d& centre) const {
    const double half = 0.25 * std::numbers::pi * radius_, x = centre.x() - kX, z = centre.z() - kZ;
    if (x <= 0.0 && x <= z) return -half + x;
    if (z <= 0.0) return half - z;
    return radius_ * std::atan2(x, z) - half;
  }

  static SurfaceSample start(double y) {
    return {{kX - kHalfWay, y, kZ}, Vector3d::UnitZ(), Vector3d::UnitX(), 0.0};
  }

 private:
  static constexpr double kX = 0.15, kZ = 0.08;
  double radius_;
};

}  // namespace

EdgeResponse edge_response(const EvaluationSetup& setup) {
  const auto surface = make_surface("box");
  const double r = setup.tool.thinnest(), depth = 0.5 * r;
  const Edge edge(r);
  std::vector<double> off;
  double worst = 0.0, where = kNone;
  CurveBins error(-2.0 * kHalfWay, 2.0 * kHalfWay, kBins);
  const auto cross = [&](Hand& hand, Random& random) {
    const double y = random.uniform(-0.05, 0.05);
    hand.come_down(Edge::start(y), depth);
    return follow(hand, edge.around(y, depth));
  };
  cross_all(*surface, setup, ball(r), cross, [&](const Path& path) {
    double most = 0.0;
    for (const Vector3d& p : path) {
      const double e = surface->distance(p) - r, at = edge.way(p);
      error.add(at, e);
      most = std::max(most, std::abs(e));
      if (std::abs(e) <= worst) continue;
      worst = std::abs(e);
      where = at;
    }
    off.push_back(most);
  });
  return {spread_of(off), where, error.curve()};
}

}  // namespace palpate
