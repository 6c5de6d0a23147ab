#include <palpate/study/trials.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include <palpate/geometry/solids.h>
#include <palpate/study/evaluation_hand.h>
#include <palpate/study/seen_surface.h>
#include <palpate/study/trial_place.h>
#include <palpate/study/trial_tools.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr std::array<std::string_view, 7> kPlaces{"face",  "edge",  "corner", "hole",
                                                  "plate", "sheet", "inside"};

constexpr double kNoise = 0.25;              // standard deviation, in spacings
constexpr double kTilt = 10.0 * pi / 180.0;  // standard deviation. [rad]
constexpr double kSlowestStroke = 0.05, kSlow = 0.5, kFastestStroke = 50.0;  // [m/s]
constexpr double kShallowTrial = 3.0;                                        // in shortest semi-axes
constexpr double kFurther = 0.03;                                       // length of a stroke from inside. [m]
constexpr double kStartsAt = 1.5, kApart = 0.02, kFarthestApart = 0.3;  // in tool radii; [m]
constexpr int kRestTicks = 10, kPatience = 5, kStart = 8;               // [ticks]
constexpr double kSilentShare = 0.1;                                    // fraction of stiffness times depth
constexpr double kSilentDepth = 0.005, kFeltDepth = 0.004;              // [m]
constexpr double kSunk = 0.5;                                           // in shortest semi-axes
constexpr double kHalfMm = 0.0005, kMm = 0.001;                         // [m]
constexpr std::size_t kScenes = 2;

/// A place with its Gaussians.
struct Scene {
  Scene(const TrialSetup& setup, std::size_t variant)
      : place(setup.place, setup.tool, variant),
        noise(kNoise * place.spacing()),
        gaussians(make_capture(place.surface(), {setup.seed + variant, place.spacing(), noise, kTilt},
                               setup.defects)),
        index(gaussians, SceneFilter{}, Similarity{}),
        seen(gaussians, Similarity{}) {}

  TrialPlace place;
  double noise;
  GaussianScene gaussians;
  SceneIndex index;
  SeenSurface seen;
};

struct Way {
  Vector3d from, along;
  double length = 0.0;       ///< Unit: [m].
  double start_depth = 0.0;  ///< of a start inside. Unit: [m].

  Vector3d at(double s) const { return from + s * along; }
};

Pose upright(const Vector3d& position) { return {position, Eigen::Quaterniond::Identity()}; }

bool overlaps(const SceneIndex& index, const Tool& tool, const Vector3d& position) {
  ContactSet contacts;
  query(index, tool, upright(position), contacts);
  return !contacts.contacts.empty();
}

/// Bisects for the value from which `is` is true, between `low`, where it is false, and `high`, where it is
/// true.
template <class Is>
double where_begins(double low, double high, const Is& is) {
  constexpr int kHalvings = 20;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (is(middle) ? high : low) = middle;
  }
  return high;
}

/// Height of a point above the true surface; negative below, also for a sheet.
double height(const Scene& scene, const TrialAim& aim, const Vector3d& point) {
  return scene.place.is_flat() ? (point - aim.point).dot(aim.normal) : scene.place.surface().distance(point);
}

/// Distance at which the tool first touches the true surface; nothing if not within `longest`.
std::optional<double> true_touch(const Scene& scene, const TrialAim& aim, const Way& way, double longest) {
  constexpr double kStep = 1e-3;
  if (scene.place.is_flat())
    return (height(scene, aim, way.from) - aim.tool.support(-aim.normal)) / -way.along.dot(aim.normal);
  const auto touches = [&](double s) {
    return deepest(scene.place.surface(), aim.tool, upright(way.at(s))) > 0.0;
  };
  double s = kStep;
  while (s <= longest && !touches(s)) s += kStep;
  if (s > longest) return {};
  return where_begins(s - kStep, s, touches);
}

/// Distance at which the tool meets the seen surface: by the rays of its whole cross-section, and by denser
/// ones where it is about to touch the true surface, at `touch`.
std::optional<double> seen_touch(const Scene& scene, const TrialAim& aim, const Way& way, double touch) {
  const Tool& tool = aim.tool;
  constexpr int kRingsOfMany = 2;
  constexpr std::size_t kMostRays = 300;
  const double band = 4.0 * scene.noise;
  const SeenRays rays(scene.seen, way.from, way.along, tool.radius());
  std::optional<double> first =
      rays.first_touch(tool, Vector3d::Zero(), tool.parts().size() > 1 ? kRingsOfMany : SeenRays::kRings);
  std::vector<std::pair<double, Vector3d>> near;
  for (const Vector3d& point : front_of(tool, way.along, scene.place.spacing())) {
    const double clear = height(scene, aim, way.at(touch) + point);
    if (clear < band) near.emplace_back(clear, point);
  }
  const std::size_t count = std::min(near.size(), kMostRays);
  std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(count),
                            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d& point = near[i].second;
    const std::optional<double> depth = rays.depth(way.from + point);
    if (depth && (!first || *depth - point.dot(way.along) < *first)) first = *depth - point.dot(way.along);
  }
  return first;
}

/// Distances of the tool along the way at each tick: in, at rest, back, and at rest. \param in number of
/// ticks before the way back
std::vector<double> ticks_of(double length, double speed, std::size_t& in) {
  std::vector<double> ticks;
  double s = 0.0;
  while (s < length) {
    ticks.push_back(s);
    s += speed * kTick;
  }
  ticks.insert(ticks.end(), kRestTicks + 1, length);
  in = ticks.size();
  s = length - speed * kTick;
  while (s > 0.0) {
    ticks.push_back(s);
    s -= speed * kTick;
  }
  ticks.insert(ticks.end(), kRestTicks + 1, 0.0);
  return ticks;
}

std::uint64_t seed_of(std::uint64_t seed, std::size_t number) {
  return seed * 0x9E3779B97F4A7C15U + 0xBF58476D1CE4E5B9U * (number + 1);
}

/// Runs one stroke.
class Trial {
 public:
  Trial(const TrialSetup& setup, const Scene& scene, std::size_t number)
      : setup_(setup), scene_(scene), random_(seed_of(setup.seed, number)) {
    result_.number = number;
    result_.speed = kSlowestStroke * std::pow(kFastestStroke / kSlowestStroke, random_.uniform());
    const bool deep = random_.uniform() < 0.5;
    aim_ = scene.place.aim(random_, setup.tip_first);
    const double share = random_.uniform(0.2, 0.9);
    scene.place.starts_inside() ? from_inside(share) : from_outside(deep);
  }

  TrialStroke run(std::vector<TrialTick>* ticks, std::vector<double>* times) {
    Hand hand(scene_.index, aim_.tool, setup_.model);
    ForceSteps steps(setup_.stiffness);
    double force = 0.0;  // of the last tick
    std::size_t in = 0;
    const std::vector<double> ways = ticks_of(way_.length, result_.speed, in);
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const Vector3d position = way_.at(ways[i]);
      const ForceOutput felt = hand.at(position);
      steps.add(felt.wrench.force, position);
      force = felt.wrench.force.norm();
      const TrialTick tick{position,
                           felt.proxy.position,
                           felt.wrench.force,
                           depth_at(upright(position)),
                           depth_at(felt.proxy),
                           felt.confidence};
      if (i < in && result_.slow()) on_the_way_in(ways[i], i == 0 ? 0.0 : ways[i - 1], tick, felt.proxy);
      judge(tick, felt.proxy, i + 1 == in);
      if (ticks != nullptr) ticks->push_back(tick);
    }
    result_.stuck = scene_.place.is_flat() && !scene_.place.starts_inside() && force > 0.0;
    result_.step = steps.largest();
    if (times != nullptr) times->insert(times->end(), hand.ticks().begin(), hand.ticks().end());
    return result_;
  }

 private:
  /// Depth of the tool; for a plate or sheet, below its near side, even if it comes out behind.
  double depth_at(const Pose& pose) const {
    return scene_.place.thickness() ? below_the_plane(pose)
                                    : deepest(scene_.place.surface(), aim_.tool, pose);
  }

  /// Depth of the tool below the plane of a flat place.
  double below_the_plane(const Pose& pose) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const ToolPart& part : aim_.tool.parts()) {
      const Ellipsoid solid = part.at(pose);
      most = std::max(most, solid.support(aim_.normal) - height(scene_, aim_, solid.center));
    }
    return most;
  }

  void from_outside(bool deep) {
    const double radius = aim_.tool.radius();
    double back = kStartsAt * radius + kApart;
    const double farthest = back + kFarthestApart;
    while (back < farthest && overlaps(scene_.index, aim_.tool, aim_.point - back * aim_.along))
      back += std::max(radius, kApart);
    way_ = {aim_.point - back * aim_.along, aim_.along, 0.0, 0.0};
    const double shallow = kShallowTrial * setup_.tool.thinnest();
    const auto touch = true_touch(scene_, aim_, way_, back + radius);
    way_.length = touch.value_or(back) + (deep ? std::max(kDeepestTrial, shallow) : shallow);
    if (!touch || !result_.slow()) return;
    result_.met = touch;
    result_.seen = seen_touch(scene_, aim_, way_, *touch);
  }

  void from_inside(double share) {
    const double depth = share * setup_.tool.thinnest();
    way_ = {aim_.point + (aim_.tool.support(-aim_.normal) - depth) * aim_.normal, aim_.along, kFurther,
            depth};
  }

  void on_the_way_in(double s, double before, const TrialTick& tick, const Pose& proxy) {
    const auto touching = [&](double at) { return overlaps(scene_.index, aim_.tool, way_.at(at)); };
    if (!result_.touched && touching(s)) result_.touched = where_begins(before, s, touching);
    const double force = tick.force.norm();
    if (!result_.felt && force > 0.0) result_.felt = 0.5 * (before + s);
    if (!scene_.place.is_flat() || !result_.seen) return;
    // Orientation of the proxy: an end that yields by rotation is not as deep.
    const double turned =
        below_the_plane({tick.tool, proxy.orientation}) - below_the_plane(upright(tick.tool));
    const double depth = (s - *result_.seen) * std::abs(way_.along.dot(aim_.normal)) + turned;
    if (depth > std::min(kFeltDepth, setup_.tool.thinnest()))
      result_.magnitude.push_back(force / (setup_.stiffness * depth));
  }

  void judge(const TrialTick& tick, const Pose& proxy, bool rested) {
    const double thinnest = setup_.tool.thinnest();
    const double depth = tick.depth - way_.start_depth - scene_.noise;
    const double proxy_depth = tick.proxy_depth - way_.start_depth - scene_.noise;
    if (scene_.place.starts_inside() && starting_ > 0) {
      --starting_;
      if (!is_behind(upright(tick.tool), scene_.noise)) lets_in_ = is_behind(proxy, scene_.noise);
      return;
    }
    if (lets_in_) {  // on the inner side, which is as good as out if it stays there
      if (!is_behind(proxy, -thinnest)) result_.through = true;
      return;
    }
    const double loud = thinnest <= kSilentDepth ? thinnest : std::max(kSilentDepth, 0.5 * thinnest);
    deep_for_ = depth > loud ? deep_for_ + 1 : 0;
    if (deep_for_ > kPatience && (result_.slow() || rested) &&
        tick.force.norm() < kSilentShare * setup_.stiffness * depth)
      result_.silent = true;
    if (proxy_depth > kSunk * thinnest) result_.sunk = true;
    const auto thickness = scene_.place.thickness();
    if (thickness && is_behind(proxy, 0.5 * *thickness + scene_.noise)) result_.through = true;
  }

  /// True if the centre of a part of the tool is more than `below` below the plane of a flat place.
  bool is_behind(const Pose& proxy, double below) const {
    return std::ranges::any_of(aim_.tool.parts(), [&](const ToolPart& part) {
      return (part.at(proxy).center - aim_.point).dot(aim_.normal) < -below;
    });
  }

  const TrialSetup& setup_;
  const Scene& scene_;
  Random random_;
  TrialAim aim_;
  Way way_;
  TrialStroke result_;
  int deep_for_ = 0;
  int starting_ = kStart;  ///< ticks left in which a tool that starts inside may still come out
  bool lets_in_ = false;   ///< the tool starts inside, and the proxy has come out on the inner side
};

/// Accumulates the figures of strokes.
class Sum {
 public:
  void add(const TrialStroke& stroke) {
    ++f_.strokes;
    f_.slow += stroke.slow() ? 1 : 0;
    count(stroke.silent, stroke, f_.silent, f_.silent_strokes);
    count(stroke.sunk, stroke, f_.sunk, f_.sunk_strokes);
    count(stroke.through, stroke, f_.through, f_.through_strokes);
    count(stroke.stuck, stroke, f_.stuck, f_.stuck_strokes);
    if (!stroke.slow()) return;
    step_.push_back(stroke.step);
    magnitude_.insert(magnitude_.end(), stroke.magnitude.begin(), stroke.magnitude.end());
    if (!stroke.seen) return;
    ++f_.onsets;
    const std::optional<double> late = stroke.late();
    if (stroke.felt) {
      onset_.push_back(*stroke.felt - *stroke.seen);
      depth_.push_back(*stroke.felt - *stroke.met);
    }
    if (late) late_.push_back(*late);
    half_mm_ += late && std::abs(*late) <= kHalfMm ? 1 : 0;
    const bool in_place = late && std::abs(*late) <= kMm;
    mm_ += in_place ? 1 : 0;
    if (!in_place) f_.late_strokes.push_back(stroke.number);
  }

  TrialFigures figures(std::vector<double> times) {
    f_.onset = spread_of(std::move(onset_));
    f_.onset_depth = spread_of(std::move(depth_));
    f_.late = spread_of(std::move(late_));
    f_.within_half_mm = share_of(half_mm_, f_.onsets);
    f_.within_1mm = share_of(mm_, f_.onsets);
    f_.magnitude = spread_of(std::move(magnitude_));
    f_.step = spread_of(std::move(step_));
    f_.tick = spread_of(std::move(times));
    return f_;
  }

 private:
  static void count(bool failed, const TrialStroke& stroke, std::size_t& total,
                    std::vector<std::size_t>& numbers) {
    if (!failed) return;
    ++total;
    numbers.push_back(stroke.number);
  }

  TrialFigures f_;
  std::size_t half_mm_ = 0, mm_ = 0;
  std::vector<double> onset_, depth_, late_, magnitude_, step_;
};

}  // namespace

std::span<const std::string_view> trial_places() { return kPlaces; }

bool TrialStroke::slow() const { return speed <= kSlow; }

std::optional<double> TrialStroke::late() const {
  if (!seen || !felt) return {};
  const double reference = touched ? std::max(*seen, *touched) : *seen, half = 0.5 * speed * kTick;
  // The force began between two ticks: half a tick's motion is uncertain.
  const double off = *felt - reference;
  return std::copysign(std::max(0.0, std::abs(off) - half), off);
}

TrialFigures run_trials(const TrialSetup& setup, const Progress& progress) {
  Sum sum;
  std::vector<double> times;
  std::vector<TrialStroke> strokes(setup.strokes);
  std::size_t done = 0;
  for (std::size_t variant = 0; variant < std::min(kScenes, setup.strokes); ++variant) {
    const Scene scene(setup, variant);
    for (std::size_t i = variant; i < setup.strokes; i += kScenes) {
      strokes[i] = Trial(setup, scene, i).run(nullptr, &times);
      report(progress, "pushing", static_cast<double>(++done) / static_cast<double>(setup.strokes));
    }
  }
  for (const TrialStroke& stroke : strokes) sum.add(stroke);
  return sum.figures(std::move(times));
}

TrialStroke repeat_trial(const TrialSetup& setup, std::size_t number, std::vector<TrialTick>* ticks) {
  const Scene scene(setup, number % kScenes);
  return Trial(setup, scene, number).run(ticks, nullptr);
}

}  // namespace palpate
