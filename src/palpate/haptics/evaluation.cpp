#include <palpate/haptics/evaluation.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 1e-3;         // [s]
constexpr double kSpeed = 0.1;         // of presses and slides. [m/s]
constexpr double kFastest = 2.0;       // of pushes. [m/s]
constexpr double kShallowest = 0.004;  // where directions are judged. [m]
constexpr double kSlide = 0.03;        // [m]
constexpr double kDegree = std::numbers::pi / 180.0;

Spread spread_of(std::vector<double> values) {
  if (values.empty()) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {kNone, kNone, kNone, kNone, kNone};
  }
  return {quantile(values, 0.05), quantile(values, 0.5), quantile(values, 0.95), quantile(values, 0.99),
          quantile(values, 1.0)};
}

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

Vector3d random_direction(Random& random) {
  for (;;) {
    const Vector3d v(random.normal(), random.normal(), random.normal());
    if (v.norm() > 1e-3) return v.normalized();
  }
}

/// A tool in the scene, moved tick by tick.
class Hand {
 public:
  Hand(const SceneIndex& index, const Tool& tool, const ForceModelMaker& model)
      : tracker_(index, tool), model_(model(index)) {}

  void reset() {
    model_->reset();
    moving_ = false;
  }

  ForceOutput at(const Vector3d& position) {
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

  /// From one place to another at `speed`. `visit(felt, s)` is told every tick and how far it is, from 0 to
  /// the length.
  template <class Visit>
  void move(const Vector3d& from, const Vector3d& to, double speed, const Visit& visit) {
    const double length = (to - from).norm();
    const Vector3d along = (to - from) / length;
    const int ticks = static_cast<int>(std::ceil(length / (speed * kTick)));
    for (int k = 0; k < ticks; ++k) {
      const double s = k * speed * kTick;
      visit(at(from + s * along), s);
    }
  }

  const std::vector<double>& ticks() const { return ticks_; }

 private:
  ToolTracker tracker_;
  std::unique_ptr<ForceModel> model_;
  ContactSet contacts_;
  bool moving_ = false;
  Vector3d last_ = Vector3d::Zero();
  std::vector<double> ticks_;
};

/// How far the tool reaches from its centre along -n, oriented as the world.
double reach(const Tool& tool, const Vector3d& n) { return tool.support(-n); }

/// True if the tool touches the surface there and nowhere else, and the surface has neither edge nor border
/// for `margin` around.
bool is_smooth(const AnalyticSurface& surface, const SurfaceSample& place, const Tool& tool, double margin) {
  const double radius = tool.radius();
  if (surface.distance(place.point + (radius + 1e-4) * place.normal) < radius) return false;
  const Vector3d other = place.normal.cross(place.tangent);
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4.0;
    const Vector3d aside = margin * (std::cos(angle) * place.tangent + std::sin(angle) * other);
    // From above, so that an edge is seen from both of its sides.
    const NearestPoint there = surface.project(place.point + aside + 0.1 * margin * place.normal);
    if ((there.point - place.point).norm() < 0.7 * margin) return false;
    if (there.normal.dot(place.normal) < 0.7) return false;
  }
  return true;
}

std::vector<SurfaceSample> choose_places(const AnalyticSurface& surface, const EvaluationSetup& setup) {
  Random random(setup.seed);
  constexpr double kSpacing = 0.01;
  const std::vector<PartSample> all = surface.samples(kSpacing, random);
  std::vector<SurfaceSample> smooth, chosen;
  for (const PartSample& s : all) {
    if (is_smooth(surface, s.sample, setup.tool, 1.5 * setup.tool.radius())) smooth.push_back(s.sample);
  }
  if (smooth.empty()) {
    throw Error("{}: nowhere is it smooth enough for a tool of {} mm", setup.shape,
                1e3 * setup.tool.radius());
  }
  for (std::size_t i = 0; i < setup.places; ++i) chosen.push_back(smooth[random.index(smooth.size())]);
  return chosen;
}

/// All that an evaluation gathers.
struct Gathered {
  std::vector<double> direction, magnitude, onset, ripple, jump, loop, tick;
};

void press(Hand& hand, const SurfaceSample& place, const EvaluationSetup& setup, Gathered& gathered,
           Evaluation& result) {
  const double r = reach(setup.tool, place.normal), begin = r, deepest = 1.5 * r;
  const Vector3d outside = place.point + (r + begin) * place.normal,
                 inside = place.point + (r - deepest) * place.normal;
  bool touched = false;
  hand.reset();
  hand.move(outside, inside, kSpeed, [&](const ForceOutput& felt, double s) {
    const Vector3d& force = felt.wrench.force;
    const double depth = s - begin, size = force.norm();
    if (!touched && size > 0.0) gathered.onset.push_back(depth);
    touched = touched || size > 0.0;
    if (depth < kShallowest) return;
    if (size == 0.0) {
      ++result.silent;
      return;
    }
    gathered.direction.push_back(degrees_between(force, place.normal));
    if (force.dot(place.normal) < 0.0) ++result.flipped;
    if (setup.stiffness > 0.0) gathered.magnitude.push_back(size / (setup.stiffness * depth));
  });
}

void slide(Hand& hand, SurfaceSample place, const AnalyticSurface& surface, const EvaluationSetup& setup,
           Gathered& gathered) {
  const double r = reach(setup.tool, place.normal), depth = 0.5 * r, step = kSpeed * kTick;
  hand.reset();
  hand.move(place.point + 2.0 * r * place.normal, place.point + (r - depth) * place.normal, kSpeed,
            [](const ForceOutput&, double) {});
  double sum = 0.0, squares = 0.0, jump = 0.0;
  std::size_t n = 0;
  Vector3d last = Vector3d::Zero();
  const int ticks = static_cast<int>(kSlide / step);
  for (int tick = 0; tick < ticks; ++tick) {
    const NearestPoint next = surface.project(place.point + step * place.tangent + 0.05 * r * place.normal);
    place.point = next.point;
    place.normal = next.normal;
    place.tangent = (place.tangent - place.normal.dot(place.tangent) * place.normal).normalized();
    if (!is_smooth(surface, place, setup.tool, r)) break;
    const Vector3d force = hand.at(place.point + (r - depth) * place.normal).wrench.force;
    if (n > 0) jump = std::max(jump, (force - last).norm());
    last = force;
    sum += force.norm();
    squares += force.squaredNorm();
    ++n;
  }
  if (n < 100 || sum == 0.0) return;
  const auto count = static_cast<double>(n);
  const double mean = sum / count;
  gathered.ripple.push_back(std::sqrt(std::max(0.0, squares / count - mean * mean)) / mean);
  gathered.jump.push_back(jump);
}

void push(Hand& hand, const SurfaceSample& place, const AnalyticSurface& surface,
          const EvaluationSetup& setup, Random& random, Evaluation& result) {
  const double r = reach(setup.tool, place.normal);
  const bool fast = result.pushes % 10 == 0;
  const double speed = fast ? kFastest : random.uniform(0.1, 1.0);
  const Vector3d along = (-place.normal + 0.5 * random_direction(random)).normalized();
  bool through = false;
  hand.reset();
  hand.move(place.point - 2.5 * r * along, place.point + 3.0 * r * along, speed,
            [&](const ForceOutput& felt, double s) {
              const Vector3d tool = place.point + (s - 2.5 * r) * along, &proxy = felt.proxy.position;
              if (felt.wrench.force.squaredNorm() == 0.0) return;
              if ((proxy - tool).norm() == 0.0) {
                through = through || felt.wrench.force.dot(along) > 0.0;
                return;
              }
              const NearestPoint nearest = surface.project(proxy);
              const bool here = (nearest.point - place.point).norm() < 2.0 * r;  // a sheet ends somewhere
              const bool behind =
                  !surface.closed() && here && (proxy - nearest.point).dot(place.normal) < 0.0;
              through = through || behind || nearest.distance < 0.5 * r;
            });
  ++result.pushes;
  result.through += through ? 1 : 0;
}

void circle(Hand& hand, const SurfaceSample& place, const EvaluationSetup& setup, Gathered& gathered) {
  if (!(setup.stiffness > 0.0)) return;
  const double r = reach(setup.tool, place.normal), depth = 0.25 * r, radius = 0.25 * r;
  const Vector3d other = place.normal.cross(place.tangent), center = place.point + (r - depth) * place.normal;
  const int ticks = static_cast<int>(2.0 * std::numbers::pi * radius / (kSpeed * kTick));
  const auto point = [&](int k) {
    const double angle = 2.0 * std::numbers::pi * k / ticks;
    return Vector3d(center + radius * (std::cos(angle) * place.tangent + std::sin(angle) * other));
  };
  hand.reset();
  hand.move(point(0) + 2.0 * r * place.normal, point(0), kSpeed, [](const ForceOutput&, double) {});
  // The first time round the model finds its way; the second counts.
  double work = 0.0;
  Vector3d last = hand.at(point(0)).wrench.force;
  for (int k = 1; k <= 2 * ticks; ++k) {
    const Vector3d force = hand.at(point(k)).wrench.force;
    if (k > ticks) work += 0.5 * (force + last).dot(point(k) - point(k - 1));
    last = force;
  }
  gathered.loop.push_back(std::abs(work) / (0.5 * setup.stiffness * depth * depth));
}

}  // namespace

Evaluation evaluate(const EvaluationSetup& setup, const Progress& progress) {
  const auto surface = make_surface(setup.shape);
  const std::vector<SurfaceSample> places = choose_places(*surface, setup);
  Random random(setup.seed + 1);
  Evaluation result{};
  Gathered gathered;
  for (std::size_t k = 0; k < setup.scenes; ++k) {
    ProceduralOptions options = setup.scene;
    options.seed += k;
    const SceneIndex index(make_scene(*surface, options), SceneFilter{}, Similarity{});
    Hand hand(index, setup.tool, setup.model);
    for (std::size_t i = k; i < places.size(); i += setup.scenes) {
      press(hand, places[i], setup, gathered, result);
      slide(hand, places[i], *surface, setup, gathered);
      push(hand, places[i], *surface, setup, random, result);
      circle(hand, places[i], setup, gathered);
    }
    gathered.tick.insert(gathered.tick.end(), hand.ticks().begin(), hand.ticks().end());
    report(progress, "evaluating", static_cast<double>(k + 1) / static_cast<double>(setup.scenes));
  }
  result.direction = spread_of(gathered.direction);
  result.magnitude = spread_of(gathered.magnitude);
  result.onset = spread_of(gathered.onset);
  result.ripple = spread_of(gathered.ripple);
  result.jump = spread_of(gathered.jump);
  result.loop = spread_of(gathered.loop);
  result.tick = spread_of(gathered.tick);
  return result;
}

StepResponse step_response(const ForceModelMaker& model, const Tool& tool, const ProceduralOptions& scene,
                           std::size_t crossings, std::uint64_t seed) {
  constexpr double kHeight = 0.003, kTravel = 0.015, kHalfWay = 0.04;  // [m]
  const auto surface = make_surface("step");
  const SceneIndex index(make_scene(*surface, scene), SceneFilter{}, Similarity{});
  Hand hand(index, tool, model);
  Random random(seed);
  const double r = tool.radius(), step = kSpeed * kTick;
  const auto window = static_cast<std::size_t>(kTravel / step);
  std::vector<double> felt, rise_over;
  for (std::size_t i = 0; i < crossings; ++i) {
    const double y = random.uniform(-0.1, 0.1), height = 0.0;  // the tool's centre in the lower plane
    hand.reset();
    hand.move({-kHalfWay, y, 2.0 * r}, {-kHalfWay, y, height}, kSpeed, [](const ForceOutput&, double) {});
    std::vector<double> heights;
    hand.move({-kHalfWay, y, height}, {kHalfWay, y, height}, kSpeed,
              [&](const ForceOutput& at, double) { heights.push_back(at.proxy.position.z()); });
    double most = 0.0;
    for (std::size_t k = 0; k + window < heights.size(); ++k)
      most = std::max(most, heights[k + window] - heights[k]);
    felt.push_back(most);
    const double low = heights.front(), rise = heights.back() - low;
    const auto first_above = [&](double part) {
      return std::find_if(heights.begin(), heights.end(), [&](double z) { return z > low + part * rise; });
    };
    rise_over.push_back(step * static_cast<double>(first_above(0.9) - first_above(0.1)));
  }
  return {kHeight, spread_of(felt), kTravel, spread_of(rise_over)};
}

}  // namespace palpate
