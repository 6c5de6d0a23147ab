#include <palpate/study/room_path.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSpeed = 0.5, kSlowSpeed = 0.1;  // [m/s]
constexpr double kPeakToMeanSpeed = 15.0 / 8.0;   // ratio of peak to mean speed of a minimum-jerk motion
constexpr double kShortest = 0.25;                // shortest duration of a motion. [s]
constexpr double kSlowFrom = 0.15;                // distance before first contact of the slow motion. [m]
constexpr double kClearance = 0.12;               // clearance above the scene in travel. [m]
constexpr double kCheckStep = 0.01;               // distance between two checks for obstacles. [m]
constexpr double kFine = 2e-4;                    // step of the search for first contact. [m]
constexpr std::size_t kSolid = 3;                 // least number of Gaussians of a surface
constexpr std::size_t kCandidates = 12;           // candidates to choose from

/// Fraction of a minimum-jerk motion (Flash and Hogan 1985) done after the fraction `u` of its time.
double share_at(double u) { return u * u * u * (10.0 - u * (15.0 - 6.0 * u)); }

class Route {
 public:
  Route(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
        const RoomPathOptions& options)
      : query_(query), tool_(tool), options_(options) {
    Eigen::AlignedBox3d box;
    for (const Ellipsoid& ellipsoid : scene.ellipsoids) box.extend(ellipsoid.center);
    height_ = std::min(box.max().z() + tool.radius() + kClearance, options.reach.max().z());
    middle_ = box.center();
  }

  /// Returns the touch at `place` if the hand can reach and leave it.
  std::optional<RoomTouch> touch_at(const PressPlace& place) {
    RoomTouch touch{place, 0.0, 0.0, 0.0, 0.0};
    const Vector3d in = place.inward;
    const Vector3d from = place.touch.position - 2.0 * tool_.radius() * in;
    const Vector3d to = place.touch.position + 2.0 * tool_.radius() * in;
    const auto contact = first_contact(from, to);
    if (!contact) return std::nullopt;
    touch.place.touch = {*contact, options_.home.orientation};
    const Vector3d off = standoff(touch), deepest = *contact + options_.press * in;
    const Vector3d slid = deepest + options_.slide * place.along;
    for (const Vector3d& p : {off, deepest, slid, Vector3d(slid - (deepest - off))}) {
      if (!options_.reach.contains(p)) return std::nullopt;
    }
    const Vector3d near = *contact - 0.5 * (*contact - off).normalized() * kFine;
    if (!free(above(off), off) || !free(off, near - 2.0 * kFine * in)) return std::nullopt;
    if (!free(above(away(touch)), away(touch))) return std::nullopt;
    return touch;
  }

  /// Selects the touches that are farthest apart, ordered around the middle of the scene.
  std::vector<RoomTouch> chosen(const std::vector<RoomTouch>& from) const {
    std::vector<RoomTouch> touches{from.front()};
    std::vector<double> least(from.size(), std::numeric_limits<double>::infinity());
    while (touches.size() < options_.touches) {
      for (std::size_t i = 0; i < from.size(); ++i)
        least[i] = std::min(least[i], difference(from[i], touches.back()));
      const auto next = std::max_element(least.begin(), least.end());
      touches.push_back(from[static_cast<std::size_t>(next - least.begin())]);
    }
    std::sort(touches.begin(), touches.end(),
              [&](const RoomTouch& a, const RoomTouch& b) { return angle(a) < angle(b); });
    return touches;
  }

  RoomPath along(std::vector<RoomTouch> touches) {
    path_.clear();
    now_ = options_.home.position;
    append(now_);
    rest(options_.wait);
    go(above(now_), kSpeed);
    for (RoomTouch& touch : touches) {
      go(above(standoff(touch)), kSpeed);
      go(standoff(touch), kSpeed);
      touch.begins = t();
      const Vector3d press = options_.press * touch.place.inward;
      go(touch.place.touch.position + press, kSlowSpeed);
      touch.pressed = t();
      rest(options_.hold);
      touch.slides = t();
      go(now_ + options_.slide * touch.place.along, 0.5 * kSlowSpeed);
      go(away(touch), kSlowSpeed);
      touch.ends = t();
      go(above(now_), kSpeed);
    }
    return {path_, std::move(touches)};
  }

 private:
  Vector3d standoff(const RoomTouch& touch) const {
    return touch.place.touch.position - (kSlowFrom + tool_.radius()) * touch.place.inward;
  }
  Vector3d away(const RoomTouch& touch) const { return standoff(touch) + options_.slide * touch.place.along; }
  Vector3d above(const Vector3d& p) const { return {p.x(), p.y(), std::max(p.z(), height_)}; }
  double angle(const RoomTouch& touch) const {
    const Vector3d way = touch.place.touch.position - middle_;
    return std::atan2(way.y(), way.x());
  }
  /// Distance between two touches, plus up to half a metre for opposite directions.
  static double difference(const RoomTouch& a, const RoomTouch& b) {
    return (a.place.touch.position - b.place.touch.position).norm() +
           0.25 * (1.0 - a.place.inward.dot(b.place.inward));
  }

  std::size_t touching(const Vector3d& p) {
    query(query_, tool_, {p, options_.home.orientation}, found_);
    return found_.contacts.size();
  }

  std::optional<Vector3d> first_contact(const Vector3d& from, const Vector3d& to) {
    const double length = (to - from).norm();
    const Vector3d way = (to - from) / length;
    if (touching(from) != 0) return std::nullopt;
    double s = 0.0;
    while (s < length && touching(from + s * way) < kSolid) s += kFine;
    if (s < length) return Vector3d(from + s * way);
    return std::nullopt;
  }

  bool free(const Vector3d& from, const Vector3d& to) {
    const int steps = static_cast<int>(std::ceil((to - from).norm() / kCheckStep));
    for (int i = 0; i <= steps; ++i) {
      const double u = steps == 0 ? 0.0 : static_cast<double>(i) / steps;
      if (touching(from + u * (to - from)) >= kSolid) return false;
    }
    return true;
  }

  double t() const { return path_.back().t; }
  void append(const Vector3d& p) {
    const double t = static_cast<double>(path_.size()) / options_.rate;
    path_.push_back({t, {p, options_.home.orientation}, {}});
  }
  void rest(double time) {
    for (int i = 0; i < static_cast<int>(time * options_.rate); ++i) append(now_);
  }
  void go(const Vector3d& to, double speed) {
    const Vector3d from = now_;
    const double time = std::max(kShortest, kPeakToMeanSpeed * (to - from).norm() / speed);
    const int steps = static_cast<int>(std::ceil(time * options_.rate));
    for (int i = 1; i <= steps; ++i) append(from + share_at(static_cast<double>(i) / steps) * (to - from));
    now_ = to;
  }

  const ContactQuery& query_;
  const Tool& tool_;
  RoomPathOptions options_;
  double height_ = 0.0;
  Vector3d middle_;
  ContactSet found_;
  Trajectory path_;
  Vector3d now_;
};

}  // namespace

RoomPath room_path(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                   const RoomPathOptions& options) {
  TouchPathOptions places;
  places.touches = static_cast<int>(kCandidates * options.touches);
  places.seed = options.seed;
  places.slide = 0.0;
  Route route(query, scene, tool, options);
  std::vector<RoomTouch> reached;
  for (const PressPlace& place : touch_places(query, scene, tool, places)) {
    if (const auto touch = route.touch_at(place)) reached.push_back(*touch);
  }
  if (reached.size() < options.touches) {
    throw Error(
        "only {} places of the scene can be reached in the box x {:.2f} to {:.2f}, y {:.2f} to {:.2f}, z "
        "{:.2f} to {:.2f} m, but {} are required; register the scene into that box (--scale, --translate), "
        "or request fewer",
        reached.size(), options.reach.min().x(), options.reach.max().x(), options.reach.min().y(),
        options.reach.max().y(), options.reach.min().z(), options.reach.max().z(), options.touches);
  }
  return route.along(route.chosen(reached));
}

}  // namespace palpate
