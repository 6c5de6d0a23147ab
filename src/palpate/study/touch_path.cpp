#include <palpate/study/touch_path.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/geometry/rotation.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/scene/lint.h>
#include <palpate/study/random.h>

namespace palpate {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

// Lengths in units of the tool's smallest semi-axis, 20 mm for the default tool.
constexpr double kMarchStep = 0.45;       // search step: below a half, so that no sheet slips between poses
constexpr double kContactError = 5e-4;    // error of first contact: 10 um
constexpr double kProbeDepth = 0.25;      // depth that distinguishes a surface from dust: 5 mm
constexpr double kPlaceError = 1.0;       // largest distance of contact from the Gaussian aimed at: 20 mm
constexpr double kStandoff = 1.5;         // distance from which the approach is slow: 30 mm
constexpr double kSlideStep = 0.1;        // distance between two searches for the surface: 2 mm
constexpr double kSlopeLimit = 1.2;       // largest rise of the surface over a slide step: 50 deg is an edge
constexpr double kApproachSpeed = 5.0;    // per second: 0.1 m/s
constexpr double kSlideSpeed = 2.5;       // per second: 0.05 m/s
constexpr double kTravelClearance = 2.0;  // in longest semi-axes, between tool and scene

// Motion in free space.
constexpr double kTurnSpeed = 3.0;                  // mean, as of a wrist. Unit: [rad/s].
constexpr double kShortestMotion = 0.2;             // bounds the acceleration of short motions. Unit: [s].
constexpr std::array kTravelRadii{1.0, 1.25, 1.5};  // tried in this order

// Limits, beyond which a typing error would fill the memory.
constexpr int kMaxTouches = 1000;
constexpr double kMaxRate = 1e5;  // Unit: [Hz].
constexpr std::size_t kMaxPoses = 5'000'000;

// The choice of places.
constexpr std::size_t kProbeContacts = 8;    // least contacts of a surface, at the probe depth
constexpr double kMaxTiltCosine = 0.766;     // 40 deg between mean contact normal and approach
constexpr std::size_t kTriesPerTouch = 300;  // largest number of Gaussians tried
constexpr std::size_t kPlacesPerTouch = 20;  // candidates to choose from
constexpr double kColorWeight = 3.0;         // of colour against position: another object before a far place
constexpr int kSlideDirections = 8;

// Peak speed, in L / T, and acceleration, in L / T^2, of a minimum-jerk motion over a length L in a time T.
constexpr double kPeakSpeed = 15.0 / 8.0, kPeakAcceleration = 5.7735;
// Curvature of a sharp bend of a slide, over a slide step. Unit: [1 / smallest semi-axis].
constexpr double kSlideBend = kSlopeLimit / kSlideStep;

/// A straight approach: pose of the tool at the distance s along `direction` from `origin`.
struct Approach {
  Vector3d origin;     ///< Unit: [m], world frame.
  Vector3d direction;  ///< unit, into the surface
  Quaterniond orientation;

  Pose at(double s) const { return {origin + s * direction, orientation}; }
  Approach from(const Vector3d& other_origin) const { return {other_origin, direction, orientation}; }
};

struct TravelSphere {
  Vector3d center;
  double radius;
};

/// Returns the least s at which a line is in the sphere; for a line that misses it, that of the nearest
/// point.
double entry(const Approach& line, const TravelSphere& sphere) {
  const Vector3d to_center = sphere.center - line.origin;
  const double middle = to_center.dot(line.direction);
  const double miss = to_center.squaredNorm() - middle * middle;
  return middle - std::sqrt(std::max(0.0, sphere.radius * sphere.radius - miss));
}

/// A contact place, with its approach and slide.
struct Touch {
  Approach approach;  ///< s = 0 is first contact
  Vector3d tangent = Vector3d::Zero();
  double slide_step = 0.0;                 ///< Unit: [m].
  std::vector<double> offsets = {0.0};     ///< first contact along the approach, one per slide step
  std::array<std::uint8_t, 3> color = {};  ///< of the Gaussian aimed at
  bool clear = false;                      ///< no contact at all on the way in, not even with haze

  double slide_length() const { return slide_step * static_cast<double>(offsets.size() - 1); }

  /// Position of first contact at `x` in [0, slide_length()] along the slide: a cubic between the steps whose
  /// slopes are the central differences (Catmull and Rom 1974).
  Vector3d surface(double x) const {
    const double step = slide_step > 0.0 ? x / slide_step : 0.0;
    const auto last = static_cast<std::ptrdiff_t>(offsets.size()) - 1;
    const auto k = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(step), 0,
                                              std::max<std::ptrdiff_t>(last - 1, 0));
    const auto at = [&](std::ptrdiff_t i) {
      return offsets[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))];
    };
    const double u = step - static_cast<double>(k);
    const double a = at(k), b = at(k + 1);
    const double slope_a = 0.5 * (b - at(k - 1));
    const double slope_b = 0.5 * (at(k + 2) - a);
    const double offset = a + u * (slope_a + u * (3.0 * (b - a) - 2.0 * slope_a - slope_b +
                                                  u * (2.0 * (a - b) + slope_a + slope_b)));
    return approach.origin + x * tangent + offset * approach.direction;
  }

  Approach exit() const { return approach.from(surface(slide_length())); }
};

/// Queries the contacts of the tool.
class Prober {
 public:
  Prober(const ContactQuery& query, const Tool& tool) : query_(query), tool_(tool), unit_(tool.thinnest()) {}

  /// The tool's shortest semi-axis. Unit: [m].
  double unit() const { return unit_; }
  const Tool& tool() const { return tool_; }

  const std::vector<Contact>& contacts(const Pose& pose) {
    palpate::query(query_, tool_, pose, found_);
    return found_.contacts;
  }

  bool solid(const Pose& pose) { return contacts(pose).size() >= kSolidContacts; }

  /// True if the tool touches no Gaussian anywhere on the line, between `from` and `to`.
  bool is_clear(const Approach& line, double from, double to) {
    double s = from;
    while (s < to && contacts(line.at(s)).empty()) s += kMarchStep * unit_;
    return s >= to && contacts(line.at(to)).empty();
  }

  /// First contact on the line, between `from` and `to`; nothing if there is none. `from` itself if
  /// the tool is in contact there.
  std::optional<double> first_contact(const Approach& line, double from, double to) {
    if (solid(line.at(from))) return from;
    for (double free = from; free < to;) {
      const double next = std::min(free + kMarchStep * unit_, to);
      if (solid(line.at(next))) return bisect(line, free, next);
      free = next;
    }
    return std::nullopt;
  }

  /// Bisects for first contact. \pre the tool is free at `free` and in contact at `touching`.
  double bisect(const Approach& line, double free, double touching) {
    while (touching - free > kContactError * unit_) {
      const double middle = 0.5 * (free + touching);
      (solid(line.at(middle)) ? touching : free) = middle;
    }
    return 0.5 * (free + touching);
  }

 private:
  const ContactQuery& query_;
  const Tool& tool_;
  double unit_;
  ContactSet found_;
};

/// Orientation with the tool's z axis along `direction`, by the smallest rotation from a tool that points
/// down: touches from above then hardly turn it.
Quaterniond pointing_along(const Vector3d& direction) {
  const Quaterniond down(0.0, 1.0, 0.0, 0.0);
  return rotation_between(-Vector3d::UnitZ(), direction) * down;
}

/// Finds places to touch.
class Search {
 public:
  Search(Prober& prober, const EllipsoidScene& scene, const TravelSphere& sphere,
         const Eigen::AlignedBox3d& bounds, const TouchPathOptions& options)
      : prober_(prober),
        scene_(scene),
        sphere_(sphere),
        bounds_(bounds),
        options_(options),
        random_(options.seed) {}

  /// Finds the touches, ordered for a short path. \throws Error if there are none.
  std::vector<Touch> touches() {
    std::vector<Touch> found = order(spread(candidates()));
    for (Touch& touch : found) find_slide(touch);
    return found;
  }

 private:
  std::vector<Touch> candidates() {
    const auto wanted = static_cast<std::size_t>(options_.touches);
    std::vector<Touch> found;
    for (std::size_t n = 0; n < kTriesPerTouch * wanted && found.size() < kPlacesPerTouch * wanted; ++n) {
      const std::size_t i = random_.index(scene_.size());
      const Ellipsoid& target = scene_.ellipsoids[i];
      if (!bounds_.contains(target.center) || target.radius() > kGiantShare * bounds_.diagonal().norm())
        continue;
      if (const auto touch = touch_at(target)) {
        found.push_back(*touch);
        if (!scene_.color.empty()) found.back().color = scene_.color[i];
      }
    }
    keep_clear(found);
    if (found.empty()) {
      throw Error(
          "touch path: no surface that this tool can press on from outside was found in {} tries; "
          "keep more Gaussians (a lower opacity threshold), make them larger (a higher sigma), or scale the "
          "scene to the tool: the scene is now {:.3g} m across, the tool {:.3g} m (palpate setup proposes a "
          "--scale)",
          kTriesPerTouch * wanted, bounds_.diagonal().norm(), 2.0 * prober_.tool().longest());
    }
    return found;
  }

  /// Drops places that are approached through haze, if there are enough others.
  void keep_clear(std::vector<Touch>& found) const {
    if (std::ranges::count_if(found, &Touch::clear) >= options_.touches)
      std::erase_if(found, [](const Touch& touch) { return !touch.clear; });
  }

  /// Finds a touch against the flattest axis of `target`: inwards if that is possible, otherwise outwards.
  std::optional<Touch> touch_at(const Ellipsoid& target) {
    int flattest = 0;
    target.axes.colwise().norm().minCoeff(&flattest);
    // The axis itself is zero for a disc without thickness.
    const Vector3d across = target.axes.col((flattest + 1) % 3).cross(target.axes.col((flattest + 2) % 3));
    if (across.isZero(0.0)) return std::nullopt;  // a needle
    Vector3d normal = across.stableNormalized();
    if (normal.dot(target.center - sphere_.center) < 0.0) normal = -normal;
    if (auto touch = touch_along(target, -normal)) return touch;
    return touch_along(target, normal);
  }

  std::optional<Touch> touch_along(const Ellipsoid& target, const Vector3d& direction) {
    Approach line{target.center, direction, pointing_along(direction)};
    const Vector3d ahead = line.at(0.0).orientation.conjugate() * direction;
    const double expected = -(prober_.tool().support(ahead) + target.support(direction));
    const double reach = kPlaceError * prober_.unit();
    const auto contact = prober_.first_contact(line, expected - reach, expected + reach);
    if (!contact || *contact <= expected - reach) return std::nullopt;
    if (!presses_on_surface(line, *contact) || !is_free(line, expected - reach)) return std::nullopt;
    Touch touch{line.from(line.at(*contact).position)};
    touch.clear = is_clear(touch.approach);
    return touch;
  }

  /// True if the tool meets many Gaussians below `contact`, which on average face the approach.
  bool presses_on_surface(const Approach& line, double contact) {
    const double depth = std::max(options_.press, kProbeDepth * prober_.unit());
    const auto& contacts = prober_.contacts(line.at(contact + depth));
    if (contacts.size() < kProbeContacts) return false;
    Vector3d normal = Vector3d::Zero();
    for (const Contact& c : contacts) normal += c.depth * c.normal;
    return -normal.dot(line.direction) > kMaxTiltCosine * normal.norm();
  }

  /// True if nothing solid is on the line between the sphere and `to`.
  bool is_free(const Approach& line, double to) {
    return !prober_.first_contact(line, std::min(entry(line, sphere_), to), to);
  }

  /// True if nothing at all is on the line between the sphere and where the slow approach begins.
  bool is_clear(const Approach& line) {
    const double begin = -kStandoff * prober_.unit();
    return prober_.is_clear(line, std::min(entry(line, sphere_), begin), begin);
  }

  /// Difference of two places: in position, relative to the scene, and in colour, relative to black against
  /// white, since objects of another colour are mostly other objects.
  double difference(const Touch& a, const Touch& b) const {
    double color = 0.0;
    for (std::size_t k = 0; k < 3; ++k) color += std::pow((a.color[k] - b.color[k]) / 255.0, 2) / 3.0;
    const Vector3d way = (a.approach.origin - b.approach.origin) / bounds_.diagonal().norm();
    return std::sqrt(way.squaredNorm() + kColorWeight * kColorWeight * color);
  }

  /// Selects as many as requested, each as different as possible from all before it; fewer if all others are
  /// at the same places.
  std::vector<Touch> spread(const std::vector<Touch>& from) const {
    std::vector<Touch> chosen{from.front()};
    std::vector<double> least(from.size(), std::numeric_limits<double>::infinity());
    while (chosen.size() < static_cast<std::size_t>(options_.touches)) {
      const Touch& last = chosen.back();
      for (std::size_t i = 0; i < from.size(); ++i) {
        const double way = (from[i].approach.origin - last.approach.origin).norm();
        least[i] = std::min(least[i], way < prober_.unit() ? 0.0 : difference(from[i], last));
      }
      const auto next = std::ranges::max_element(least);
      if (*next == 0.0) break;
      chosen.push_back(from[static_cast<std::size_t>(next - least.begin())]);
    }
    return chosen;
  }

  Vector3d entry_direction(const Touch& touch) const {
    const Pose pose = touch.approach.at(entry(touch.approach, sphere_));
    return (pose.position - sphere_.center).normalized();
  }

  /// Orders the touches so that each is followed by the one with the nearest entry into the sphere.
  std::vector<Touch> order(std::vector<Touch> touches) const {
    for (std::size_t i = 1; i < touches.size(); ++i) {
      const Vector3d here = entry_direction(touches[i - 1]);
      const auto next =
          std::ranges::max_element(touches.begin() + static_cast<std::ptrdiff_t>(i), touches.end(), {},
                                   [&](const Touch& t) { return here.dot(entry_direction(t)); });
      std::swap(touches[i], *next);
    }
    return touches;
  }

  /// Finds the longest slide of several directions in the surface; the first of full length if there is one.
  void find_slide(Touch& touch) {
    if (options_.slide == 0.0) return;
    const Eigen::Matrix3d R = touch.approach.orientation.toRotationMatrix();
    const double first = random_.uniform(0.0, 2.0 * pi);
    const double steps = std::ceil(options_.slide / (kSlideStep * prober_.unit()));
    touch.slide_step = options_.slide / steps;
    for (int k = 0; k < kSlideDirections && static_cast<double>(touch.offsets.size()) <= steps; ++k) {
      const double angle = first + 2.0 * pi * k / kSlideDirections;
      Touch tried = touch;
      tried.offsets = {0.0};
      tried.tangent = std::cos(angle) * R.col(0) + std::sin(angle) * R.col(1);
      follow_surface(tried, static_cast<std::size_t>(steps));
      if (tried.offsets.size() > touch.offsets.size() && exit_is_free(tried)) touch = tried;
    }
  }

  /// Finds first contact at up to `steps` slide steps; stops where the surface falls or rises too
  /// steeply to follow.
  void follow_surface(Touch& touch, std::size_t steps) {
    const double window = kSlopeLimit * touch.slide_step;
    while (touch.offsets.size() <= steps) {
      const double x = touch.slide_step * static_cast<double>(touch.offsets.size());
      const Approach line = touch.approach.from(touch.approach.origin + x * touch.tangent);
      const double low = touch.offsets.back() - window;
      const double high = touch.offsets.back() + window;
      if (prober_.solid(line.at(low)) || !prober_.solid(line.at(high))) break;
      touch.offsets.push_back(prober_.bisect(line, low, high));
    }
  }

  bool exit_is_free(const Touch& touch) {
    return is_free(touch.exit(), -kSlopeLimit * touch.slide_step) && (!touch.clear || is_clear(touch.exit()));
  }

  Prober& prober_;
  const EllipsoidScene& scene_;
  TravelSphere sphere_;
  Eigen::AlignedBox3d bounds_;
  const TouchPathOptions& options_;
  Random random_;
};

/// A part of the path: pose(u) for u in [0, 1].
struct Motion {
  double duration;  ///< Unit: [s].
  std::function<Pose(double u)> pose;
};

/// Duration of a hand's motion over `length` at a mean speed of at most `mean`. \param bend angle by which
/// the path turns. Unit: [rad].
double duration_of(double length, double bend, double mean, const TouchPathOptions& hand) {
  // On a bend, v^2 / r adds to the acceleration.
  const double peak = std::hypot(kPeakAcceleration, kPeakSpeed * kPeakSpeed * bend);
  return std::max({length / mean, kPeakSpeed * length / hand.speed,
                   std::sqrt(peak * length / hand.acceleration), kShortestMotion});
}

Motion straight(const Approach& line, double from, double to, double mean, const TouchPathOptions& hand) {
  return {duration_of(std::abs(to - from), 0.0, mean, hand),
          [=](double u) { return line.at(from + u * (to - from)); }};
}

/// Fraction of a minimum-jerk motion (Flash and Hogan 1985), as of a reaching hand, that is done after the
/// fraction `x` of its time.
double progress(double x) { return x * x * x * (10.0 + x * (6.0 * x - 15.0)); }

/// The same motion, slowed down until its acceleration nowhere exceeds that of a hand.
Motion within(Motion motion, const TouchPathOptions& hand) {
  constexpr int kSteps = 2000;
  double most = 0.0;  // largest second difference of the position
  const auto at = [&](int k) { return motion.pose(progress(static_cast<double>(k) / kSteps)).position; };
  Eigen::Vector3d before = at(0), now = at(1);
  for (int i = 1; i < kSteps; ++i) {
    const Eigen::Vector3d next = at(i + 1);
    most = std::max(most, (next - 2.0 * now + before).norm());
    before = std::exchange(now, next);
  }
  const double acceleration = most * kSteps * kSteps / (motion.duration * motion.duration);
  motion.duration *= std::sqrt(std::max(1.0, acceleration / hand.acceleration));
  return motion;
}

/// Motion along the great circle from one pose on the sphere to another; between opposite points, along any
/// of them.
Motion arc(const TravelSphere& sphere, const Pose& from, const Pose& to, const TouchPathOptions& hand) {
  const Vector3d a = from.position - sphere.center;
  const Vector3d b = to.position - sphere.center;
  const Quaterniond turn = rotation_between(a, b);
  const double angle = turn.angularDistance(Quaterniond::Identity());
  const double spin = from.orientation.angularDistance(to.orientation);
  const double length = angle * std::max(a.norm(), b.norm()) + std::abs(b.norm() - a.norm());
  const double duration = std::max(duration_of(length, angle, hand.speed, hand), spin / kTurnSpeed);
  return {duration, [=](double u) {
            const double r = a.norm() + u * (b.norm() - a.norm());  // equal, unless a line missed the sphere
            const Vector3d direction = Quaterniond::Identity().slerp(u, turn) * a.normalized();
            return Pose{sphere.center + r * direction, from.orientation.slerp(u, to.orientation)};
          }};
}

/// The path as a sequence of motions, either free or near the surface.
class Script {
 public:
  Script(const TravelSphere& sphere, double unit, const TouchPathOptions& options)
      : sphere_(sphere), unit_(unit), options_(options) {}

  void append(const Touch& touch) {
    const Approach& in = touch.approach;
    const Approach out = touch.exit();
    const double entry_s = entry(in, sphere_);
    const double exit_s = entry(out, sphere_);
    const double standoff_in = std::max(-kStandoff * unit_, entry_s);
    const double standoff_out = std::max(-kStandoff * unit_, exit_s);
    const double approach_speed = kApproachSpeed * unit_, any_speed = options_.speed;

    if (!motions_.empty()) add(arc(sphere_, motions_.back().pose(1.0), in.at(entry_s), options_), true);
    add(straight(in, entry_s, standoff_in, any_speed, options_), true);
    add(straight(in, standoff_in, options_.press, approach_speed, options_), false);
    if (const double length = touch.slide_length(); length > 0.0) {
      const double press = options_.press;
      // Slow enough for a sharp bend, on the steepest surface.
      const double bends = std::sqrt(options_.acceleration * unit_ / kSlideBend) / kPeakSpeed;
      const double mean = std::min(kSlideSpeed * unit_, bends);
      const Motion slide{duration_of(std::hypot(1.0, kSlopeLimit) * length, 0.0, mean, options_),
                         [=](double u) { return touch.approach.from(touch.surface(u * length)).at(press); }};
      add(within(slide, options_), false);
    }
    add(straight(out, options_.press, standoff_out, approach_speed, options_), false);
    add(straight(out, standoff_out, exit_s, any_speed, options_), true);
  }

  /// Number of poses of the free motions at which the tool touches anything.
  std::size_t collisions(Prober& prober) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      if (!free_[i]) continue;
      const double length = path_length(motions_[i]);
      const auto steps = static_cast<std::size_t>(length / (kMarchStep * prober.unit())) + 1;
      for (std::size_t k = 0; k <= steps; ++k) {
        const double u = static_cast<double>(k) / static_cast<double>(steps);
        if (!prober.contacts(motions_[i].pose(u)).empty()) ++count;
      }
    }
    return count;
  }

  /// Samples the path at the requested rate.
  Trajectory sampled() const {
    Trajectory trajectory;
    double begin = 0.0;
    for (const Motion& motion : motions_) {
      while (true) {
        const double t = static_cast<double>(trajectory.size()) / options_.rate;
        const double x = (t - begin) / motion.duration;
        if (x >= 1.0) break;
        if (trajectory.size() == kMaxPoses) refuse_length();
        append(trajectory, t, motion.pose(progress(x)));
      }
      begin += motion.duration;
    }
    append(trajectory, static_cast<double>(trajectory.size()) / options_.rate, motions_.back().pose(1.0));
    return trajectory;
  }

 private:
  [[noreturn]] void refuse_length() const {
    double seconds = 0.0;
    for (const Motion& motion : motions_) seconds += motion.duration;
    throw Error(
        "touch path: a hand takes {:.0f} s for {} touches of a scene of {:.3g} m, more than {} poses; make "
        "the scene smaller (palpate setup proposes a --scale), or request fewer touches or a lower rate",
        seconds, options_.touches, 2.0 * sphere_.radius, kMaxPoses);
  }

  void add(Motion motion, bool free) {
    motions_.push_back(std::move(motion));
    free_.push_back(free);
  }

  static void append(Trajectory& trajectory, double t, const Pose& pose) {
    TimedPose timed;
    timed.t = t;
    timed.pose = pose;
    trajectory.push_back(timed);
  }

  /// Upper bound of the length of a motion: an arc is at most pi / 2 times its chord through the middle.
  static double path_length(const Motion& motion) {
    const Vector3d a = motion.pose(0.0).position;
    const Vector3d m = motion.pose(0.5).position;
    const Vector3d b = motion.pose(1.0).position;
    return 0.5 * pi * ((m - a).norm() + (b - m).norm());
  }

  TravelSphere sphere_;
  double unit_;
  TouchPathOptions options_;
  std::vector<Motion> motions_;
  std::vector<bool> free_;
};

void check(const EllipsoidScene& scene, const Tool& tool, const TouchPathOptions& options) {
  const auto not_negative = [](double v) { return v >= 0.0 && std::isfinite(v); };
  if (options.touches < 1 || options.touches > kMaxTouches)
    throw Error("touch path: {} touches: must be 1 to {}", options.touches, kMaxTouches);
  if (!not_negative(options.press))
    throw Error("touch path: press {} m: must be finite and not negative", options.press);
  if (!not_negative(options.slide))
    throw Error("touch path: slide {} m: must be finite and not negative", options.slide);
  if (!(options.rate > 0.0 && options.rate <= kMaxRate))
    throw Error("touch path: rate {} Hz: must be positive and at most {}", options.rate, kMaxRate);
  if (!(options.speed > 0.0 && options.acceleration > 0.0))
    throw Error("touch path: speed {} m/s, acceleration {} m/s^2: must be positive", options.speed,
                options.acceleration);
  if (!(tool.thinnest() > 0.0 && std::isfinite(tool.radius())))
    throw Error("touch path: the semi-axes of the tool must be positive and finite");
  if (scene.size() == 0)
    throw Error("touch path: the scene is empty; keep more Gaussians (a lower opacity threshold)");
}

/// The script on the smallest of the travel spheres that is free of contact, otherwise on the one with the
/// fewest.
Script best_script(Prober& prober, const std::vector<Touch>& touches, const TravelSphere& sphere,
                   const TouchPathOptions& options) {
  std::optional<Script> best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const double factor : kTravelRadii) {
    Script script({sphere.center, factor * sphere.radius}, prober.unit(), options);
    for (const Touch& touch : touches) script.append(touch);
    const std::size_t collisions = script.collisions(prober);
    if (collisions < least) {
      least = collisions;
      best = std::move(script);
    }
    if (least == 0) break;
  }
  return *best;
}

/// Sphere around the scene, with room for the tool.
TravelSphere travel_sphere(const Eigen::AlignedBox3d& bounds, const Tool& tool) {
  return {bounds.center(), 0.5 * bounds.diagonal().norm() + kTravelClearance * tool.longest()};
}

}  // namespace

std::vector<PressPlace> touch_places(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                                     const TouchPathOptions& options) {
  check(scene, tool, options);
  const Eigen::AlignedBox3d bounds = central_box(scene);
  Prober prober(query, tool);
  std::vector<PressPlace> places;
  for (const Touch& touch : Search(prober, scene, travel_sphere(bounds, tool), bounds, options).touches()) {
    const Vector3d& inward = touch.approach.direction;
    places.push_back({touch.approach.at(0.0), inward,
                      touch.tangent.isZero(0.0) ? Vector3d(inward.unitOrthogonal()) : touch.tangent});
  }
  return places;
}

Trajectory touch_path(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                      const TouchPathOptions& options) {
  check(scene, tool, options);
  const Eigen::AlignedBox3d bounds = central_box(scene);
  const TravelSphere sphere = travel_sphere(bounds, tool);
  Prober prober(query, tool);
  const std::vector<Touch> touches = Search(prober, scene, sphere, bounds, options).touches();
  return best_script(prober, touches, sphere, options).sampled();
}

}  // namespace palpate
