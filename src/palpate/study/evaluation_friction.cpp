#include <algorithm>

#include <palpate/study/evaluation_strokes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSlideLength = 0.03;               // length of the evaluated part. [m]
constexpr std::size_t kRests = 4;                   // rests of ten seconds each: few, since they take long
constexpr int kSettle = 200, kTenSeconds = 10'000;  // ticks

}  // namespace

void Rubs::at(Hand& hand, const SurfaceSample& place) {
  if (const auto coefficient = measured_friction(hand, surface_, place, friction_))
    coefficient_.push_back(*coefficient);
  if (creep_.size() < kRests) rest(hand, place);
}

std::optional<double> measured_friction(Hand& hand, const AnalyticSurface& surface,
                                        const SurfaceSample& start, double friction) {
  const double r = reach(hand.tool(), start.normal), depth = 0.5 * r;
  const int until_it_slips = ticks_on(2.0 * friction * depth);
  double drag = 0.0, pressing = 0.0;
  hand.come_down(start, depth);
  SurfaceSample place = start;
  for (int tick = 0; tick < until_it_slips + ticks_on(kSlideLength); ++tick) {
    place = next_place(surface, place, kHandStep);
    if (!tool_fits(surface, place, hand.tool()) || !is_smooth(surface, place, r)) break;
    const ForceOutput felt = hand.at(centre_at(place, hand.tool(), depth));
    if (tick < until_it_slips) continue;
    const Vector3d normal = surface.project(felt.proxy.position).normal;
    const Vector3d along = (place.tangent - normal.dot(place.tangent) * normal).normalized();
    drag -= felt.wrench.force.dot(along);
    pressing += felt.wrench.force.dot(normal);
  }
  return pressing > 0.0 ? std::optional(drag / pressing) : std::nullopt;
}

void Rubs::rest(Hand& hand, const SurfaceSample& place) {
  const double depth = 0.5 * reach(hand.tool(), place.normal);
  hand.come_down(place, depth);
  const Vector3d below = centre_at(place, hand.tool(), depth);
  const Vector3d aside = below + 0.5 * friction_ * depth * place.tangent;
  hand.move(below, aside, kHandSpeed, [](const ForceOutput&, double) {});
  Vector3d before = below;
  for (int tick = 0; tick < kSettle; ++tick) before = hand.at(aside).proxy.position;
  double farthest = 0.0;
  for (int tick = 0; tick < kTenSeconds; ++tick)
    farthest = std::max(farthest, (hand.at(aside).proxy.position - before).norm());
  creep_.push_back(farthest);
}

void Rubs::tell(Evaluation& result) const {
  result.friction = spread_of(coefficient_);
  result.creep = spread_of(creep_);
}

}  // namespace palpate
