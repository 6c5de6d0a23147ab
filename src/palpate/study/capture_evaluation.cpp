#include <palpate/study/capture_evaluation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <palpate/base/quantile.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/study/evaluation_hand.h>
#include <palpate/study/random.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kNear = 0.005;                   // tolerance of the onset of force. [m]
constexpr double kShallow = 0.005, kDeep = 0.01;  // depths at which silence is judged. [m]
constexpr double kPush = 3.0;                     // largest depth, in tool radii
constexpr double kSlide = 0.1, kSample = 1e-3;    // [m]
constexpr double kSilent = 0.1, kStrong = 3.0;    // fractions of stiffness times depth
constexpr double kUntouched = 1.0;                // [N]

}  // namespace

std::vector<CaptureAim> capture_aims(const EllipsoidScene& kept, const SeenSurface& seen, const Tool& tool,
                                     std::size_t count, std::uint64_t seed, int rings,
                                     const Progress& progress) {
  constexpr std::size_t kTries = 20;
  std::vector<CaptureAim> aims;
  if (kept.size() == 0) return aims;
  Eigen::AlignedBox3d box;
  for (const Ellipsoid& e : kept.ellipsoids) box.extend(e.center);
  const double far = box.diagonal().norm() + 2.0 * tool.radius();
  Random random(seed);
  for (std::size_t i = 0; i < kTries * count && aims.size() < count; ++i) {
    const Vector3d at = kept.ellipsoids[random.index(kept.size())].center, along = random_direction(random);
    const Vector3d from = at - far * along;
    const SeenRays rays(seen, from, along, tool.radius());
    if (const auto touch = rays.first_touch(tool, Vector3d::Zero(), rings))
      aims.push_back({from, along, *touch});
    report(progress, "selecting pushes", static_cast<double>(aims.size()) / static_cast<double>(count));
  }
  return aims;
}

CaptureEvaluation::CaptureEvaluation(const SceneIndex& index, const SeenSurface& seen, const Tool& tool,
                                     const ForceModelMaker& model, double stiffness, int rings)
    : index_(index),
      seen_(seen),
      tool_(tool),
      stiffness_(stiffness),
      rings_(rings),
      hand_(std::make_unique<Hand>(index, tool, model)) {}

CaptureEvaluation::~CaptureEvaluation() = default;

bool CaptureEvaluation::touches(const Vector3d& position) {
  query(index_, tool_, {position, Eigen::Quaterniond::Identity()}, contacts_);
  return !contacts_.contacts.empty();
}

double CaptureEvaluation::free_before(const CaptureAim& aim) {
  const double radius = tool_.radius();
  double way = kPush * radius;
  while (way < aim.seen && touches(aim.from + (aim.seen - way) * aim.along)) way += radius;
  return std::min(way, aim.seen);
}

bool CaptureEvaluation::slips_off(const CaptureAim& aim, double depth) const {
  constexpr int kRounds = 3, kWays = 16;
  const double silent = kSilent * depth;
  const SeenRays rays(seen_, aim.from, aim.along, tool_.radius() + silent);
  const Vector3d u = aim.along.unitOrthogonal(), v = aim.along.cross(u);
  for (int round = 1; round <= kRounds; ++round) {
    for (int k = 0; k < kWays; ++k) {
      const double aside = 0.99 * silent * round / kRounds, angle = 2.0 * std::numbers::pi * k / kWays;
      const auto touch = rays.first_touch(tool_, aside * (std::cos(angle) * u + std::sin(angle) * v), rings_);
      const double held_up = touch ? std::max(0.0, aim.seen + depth - *touch) : 0.0;
      if (std::hypot(aside, held_up) < silent) return true;
    }
  }
  return false;
}

CapturePush CaptureEvaluation::push(const CaptureAim& aim, std::vector<CaptureTick>* ticks) {
  CapturePush result;
  result.aim = aim;
  const double before = free_before(aim), deepest = kPush * tool_.radius();
  ForceSteps steps(stiffness_);
  bool shallow = false, deep = false;
  const auto feel = [&](double depth) {
    const Vector3d position = aim.from + (aim.seen + depth) * aim.along;
    const ForceOutput felt = hand_->at(position);
    const Vector3d& force = felt.wrench.force;
    steps.add(force, position);
    if (!result.touched && touches(position)) result.touched = depth;
    if (!result.touched) result.untouched_force = std::max(result.untouched_force, force.norm());
    if (ticks != nullptr) ticks->push_back({position, felt.proxy.position, force, depth});
    return force.norm();
  };
  hand_->reset();
  const int down = ticks_on(before + deepest);
  for (int k = 0; k <= down; ++k) {
    const double depth = k * kHandStep - before;
    const double force = feel(depth);
    if (!result.onset && force > 0.0) result.onset = depth;
    const bool silent = force < kSilent * stiffness_ * depth;
    if (!shallow && depth >= kShallow) {
      shallow = true;
      result.silent_5mm = silent;
    }
    if (!deep && depth >= kDeep) {
      deep = true;
      result.silent_10mm = silent;
    }
  }
  for (int k = down; k >= 0; --k) feel(k * kHandStep - before);
  result.step = steps.largest();
  result.avoidable_5mm =
      result.silent_5mm && touches(aim.from + (aim.seen + kShallow) * aim.along) && !slips_off(aim, kShallow);
  return result;
}

CaptureSlide CaptureEvaluation::slide(const CaptureAim& aim, std::vector<CaptureTick>* ticks) {
  CaptureSlide result;
  result.aim = aim;
  const double depth = 0.5 * tool_.thinnest();
  const Vector3d aside = aim.along.unitOrthogonal();
  const SeenRays rays(seen_, aim.from, aim.along, tool_.radius() + kSlide);
  std::vector<double> seen{aim.seen};
  while (static_cast<double>(seen.size()) * kSample <= kSlide) {
    const auto next = rays.first_touch(tool_, static_cast<double>(seen.size()) * kSample * aside, rings_);
    if (!next || std::abs(*next - seen.back()) > kSample) break;
    seen.push_back(*next);
  }
  result.way = kSample * static_cast<double>(seen.size() - 1);
  hand_->reset();
  ForceSteps steps(stiffness_);
  const double before = free_before(aim);
  const int down = ticks_on(before + depth);
  for (int k = 0; k <= down; ++k)
    hand_->at(aim.from + (aim.seen + std::min(depth, k * kHandStep - before)) * aim.along);
  const int across = static_cast<int>(result.way / kHandStep);
  for (int k = 0; k < across; ++k) {
    const double way = k * kHandStep, sample = way / kSample;
    const auto i = std::min(static_cast<std::size_t>(sample), seen.size() - 2);
    const double level = seen[i] + (sample - static_cast<double>(i)) * (seen[i + 1] - seen[i]);
    const Vector3d position = aim.from + (level + depth) * aim.along + way * aside;
    const ForceOutput felt = hand_->at(position);
    const double force = felt.wrench.force.norm();
    steps.add(felt.wrench.force, position);
    ++result.ticks;
    result.strong += force > kStrong * stiffness_ * depth ? 1 : 0;
    if (force < kSilent * stiffness_ * depth) {
      ++result.silent;
      result.silent_touched += touches(position) ? 1 : 0;
    }
    if (ticks != nullptr) ticks->push_back({position, felt.proxy.position, felt.wrench.force, depth});
  }
  result.step = steps.largest();
  return result;
}

CaptureFigures CaptureEvaluation::figures(const std::vector<CapturePush>& pushes,
                                          const std::vector<CaptureSlide>& slides) const {
  CaptureFigures f;
  f.pushes = pushes.size();
  f.slides = slides.size();
  std::size_t within = 0, early = 0, silent_5mm = 0, silent_10mm = 0, untouched = 0, touched = 0,
              avoidable = 0;
  std::vector<double> onset, push_step, slide_step;
  for (const CapturePush& push : pushes) {
    if (push.onset) onset.push_back(*push.onset);
    within += push.onset && std::abs(*push.onset) <= kNear ? 1 : 0;
    early += push.onset && *push.onset < -kNear ? 1 : 0;
    touched += push.touched && std::abs(*push.touched) <= kNear ? 1 : 0;
    silent_5mm += push.silent_5mm ? 1 : 0;
    silent_10mm += push.silent_10mm ? 1 : 0;
    avoidable += push.avoidable_5mm ? 1 : 0;
    untouched += push.untouched_force > kUntouched ? 1 : 0;
    push_step.push_back(push.step);
  }
  f.onset_within = share_of(within, pushes.size());
  f.early = share_of(early, pushes.size());
  f.late = share_of(pushes.size() - within - early, pushes.size());
  f.silent_5mm = share_of(silent_5mm, pushes.size());
  f.silent_10mm = share_of(silent_10mm, pushes.size());
  f.avoidable_5mm = share_of(avoidable, pushes.size());
  f.untouched = share_of(untouched, pushes.size());
  f.touched_within = share_of(touched, pushes.size());
  f.onset = spread_of(std::move(onset));
  std::size_t ticks = 0, strong = 0, silent = 0, silent_touched = 0;
  for (const CaptureSlide& slide : slides) {
    ticks += slide.ticks;
    strong += slide.strong;
    silent += slide.silent;
    silent_touched += slide.silent_touched;
    slide_step.push_back(slide.step);
  }
  f.slide_strong = share_of(strong, ticks);
  f.slide_silent = share_of(silent, ticks);
  f.slide_silent_touched = share_of(silent_touched, ticks);
  f.push_step = spread_of(std::move(push_step));
  f.slide_step = spread_of(std::move(slide_step));
  f.tick = spread_of(hand_->ticks());
  return f;
}

CaptureLikeness capture_likeness(CaptureEvaluation& first, CaptureEvaluation& second,
                                 const std::vector<CaptureAim>& aims) {
  std::vector<double> ratios;
  std::size_t silent = 0;
  for (const CaptureAim& aim : aims) {
    std::vector<CaptureTick> one, other;
    silent += first.push(aim, &one).silent_5mm != second.push(aim, &other).silent_5mm ? 1 : 0;
    // Both start without contact, but at different distances; ticks are matched backwards from the deepest
    // one.
    const std::size_t count = std::min(one.size(), other.size()) / 2;
    for (std::size_t i = 0; i < count; ++i) {
      const CaptureTick &a = one[one.size() / 2 - 1 - i], &b = other[other.size() / 2 - 1 - i];
      const double fa = a.force.norm(), fb = b.force.norm();
      if (a.depth > kShallow && fa > 0.0 && fb > 0.0) ratios.push_back(fb / fa);
    }
  }
  CaptureLikeness result;
  if (!ratios.empty()) {
    result.p10 = quantile(ratios, 0.1);
    result.p90 = quantile(ratios, 0.9);
  }
  result.ratio = spread_of(std::move(ratios));
  result.silent_in_one = share_of(silent, aims.size());
  return result;
}

}  // namespace palpate
