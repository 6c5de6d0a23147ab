#include <palpate/base/error.h>
#include <palpate/study/evaluation_strokes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSlowest = 0.1, kFast = 1.0, kFastest = 2.0;  // [m/s]
constexpr std::size_t kFastestEvery = 10;
constexpr double kBefore = 2.5, kBeyond = 3.0;  // begin and end of a push, in extents of the tool
constexpr double kAslant = 0.5;                 // sine of the largest angle from the normal
constexpr double kRounding = 1e-9;              // of the tool's position. [m]

}  // namespace

Pushes::Aim Pushes::aim(const Tool& tool, const std::vector<SurfaceSample>& places) {
  constexpr int kTries = 10000;
  for (int i = 0; i < kTries; ++i) {
    const SurfaceSample& place = places[random_.index(places.size())];
    const Vector3d along = (-place.normal + kAslant * random_direction(random_)).normalized();
    if (surface_.closed()) return {place, along};
    // Without friction, a proxy is at the point of the surface that is nearest to the tool.
    const NearestPoint end = surface_.project(place.point + kBeyond * reach(tool, place.normal) * along);
    const SurfaceSample last{end.point, end.normal, end.normal.unitOrthogonal(), place.spacing};
    const bool same_side = end.normal.dot(along) < 0.0;
    if (same_side && is_inland(surface_, last, 2.0 * tool.radius())) return {place, along};
  }
  throw Error("{}: no place is large enough for a tool of {} mm to be pushed through", surface_.name(),
              1e3 * tool.radius());
}

bool Pushes::is_through(const ForceOutput& felt, const Vector3d& position, const Aim& aim,
                        double thickness) const {
  const Vector3d &proxy = felt.proxy.position, &force = felt.wrench.force;
  const bool has_force = force.squaredNorm() > 0.0;
  if (has_force && (proxy - position).norm() < kRounding) return force.dot(aim.along) > 0.0;
  const NearestPoint nearest = surface_.project(proxy);
  const bool behind = (proxy - nearest.point).dot(nearest.normal) < 0.0;
  return behind || nearest.distance < 0.5 * thickness;
}

void Pushes::somewhere(Hand& hand, const std::vector<SurfaceSample>& places) {
  const Aim chosen = aim(hand.tool(), places);
  const double r = reach(hand.tool(), chosen.place.normal);
  const bool fast = pushes_ % kFastestEvery == 0;
  const double speed = fast ? kFastest : random_.uniform(kSlowest, kFast);
  const Vector3d begin = chosen.place.point - kBefore * r * chosen.along,
                 end = chosen.place.point + kBeyond * r * chosen.along;
  bool through = false;
  hand.reset();
  hand.move(begin, end, speed, [&](const ForceOutput& felt, double s) {
    through = through || is_through(felt, begin + s * chosen.along, chosen, hand.tool().thinnest());
  });
  ++pushes_;
  through_ += through ? 1 : 0;
  fast_ += fast ? 1 : 0;
  fast_through_ += fast && through ? 1 : 0;
}

void Pushes::tell(Evaluation& result) const {
  result.pushes = pushes_;
  result.through = through_;
  result.fast = fast_;
  result.fast_through = fast_through_;
}

}  // namespace palpate
