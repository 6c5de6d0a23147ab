#include <palpate/haptics/proxy_force.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

/// A step of the proxy that is not worth another, as a share of the longest: so short, the surface is as flat
/// as it was taken for, to a thousandth of the step, and the next tick goes on from there.
constexpr double kSettled = 0.02;

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q);
  return turn.angle() * turn.axis();
}

Eigen::Quaterniond quaternion(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (!(angle > 0.0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector / angle));
}

/// From one pose to another.
Motion motion_between(const Pose& from, const Pose& to) {
  return {to.position - from.position, rotation_vector(to.orientation * from.orientation.conjugate())};
}

Motion blend(const Motion& a, const Motion& b, double of_b) {
  return {a.translation + of_b * (b.translation - a.translation),
          a.rotation + of_b * (b.rotation - a.rotation)};
}

Motion difference(const Motion& a, const Motion& b) {
  return {a.translation - b.translation, a.rotation - b.rotation};
}

/// What gives way this much hardly holds anything. As a share of the stiffness.
constexpr double kLeastConfidence = 1e-3;

SurfaceKernel kernel_of(const ToolPart& part, const ProxyParameters& parameters, double extent) {
  const double a_min = part.semi_axes.minCoeff();
  return SurfaceKernel::for_tool(a_min, parameters.detail.value_or(ProxyParameters::kDetailOfTool * a_min),
                                 extent);
}

}  // namespace

ProxyForce::ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters)
    : parameters_(parameters),
      gyration_(tool.gyration()),
      radius_(tool.radius()),
      step_(std::numeric_limits<double>::infinity()),
      surface_(kRoom) {
  const double extent = index.usual_extent();
  for (const ToolPart& part : tool.parts()) {
    const SurfaceKernel kernel = kernel_of(part, parameters, extent);
    parts_.emplace_back(index, part, kernel);
    step_ = std::min(step_, 0.5 * kernel.reach);
  }
  contacts_.contacts.reserve(kRoom);
  planes_.reserve(SurfacePatches::kMost * parts_.size());
}

void ProxyForce::reset() {
  started_ = false;
  hold_ = {};
  for (Part& part : parts_) part.patches.clear();
}

void ProxyForce::find_planes() {
  planes_.clear();
  for (Part& part : parts_) {
    const Ellipsoid larger = part.larger.at(proxy_);
    part.tracker.query(larger, contacts_);
    surface_.assign(contacts_.contacts, larger, part.patches.kernel());
    part.patches.update(surface_, part.solid.at(proxy_));
    for (const SurfacePatch& patch : part.patches.patches()) {
      const double c = std::max(kLeastConfidence, patch.confidence);
      planes_.push_back(
          {patch.normal, (patch.foot - proxy_.position).cross(patch.normal), patch.gap, (1.0 - c) / c, 0.0});
    }
  }
}

ProxyForce::Hold ProxyForce::hold() const {
  Hold hold;
  double confidence = 0.0;
  for (const MotionConstraint& plane : planes_) {
    hold.push += plane.push;
    confidence += plane.push / (1.0 + plane.compliance);
  }
  if (hold.push > 0.0) hold.confidence = confidence / hold.push;
  return hold;
}

/// Coulomb's law for the proxy: it stays where it is, or as near to that as what presses it on, times the
/// coefficient, cannot hold it.
Motion ProxyForce::with_friction(const Motion& wanted, const Motion& free) {
  for (MotionConstraint& plane : planes_) {
    if (plane.push > 0.0) plane.gap = -plane.along(free);  // as far in or out as without friction
    plane.compliance = 0.0;
  }
  const Motion stay = constrained_motion({}, planes_, gyration_);
  const double pressed = length_of(difference(free, wanted), gyration_);
  const double slide = length_of(difference(stay, free), gyration_);
  const double lag = parameters_.friction * pressed;
  return slide <= lag ? stay : blend(free, stay, lag / slide);
}

double ProxyForce::step(const Pose& target) {
  find_planes();
  const Motion wanted = motion_between(proxy_, target);
  Motion motion = constrained_motion(wanted, planes_, gyration_);
  hold_ = hold();
  if (hold_.push > 0.0 && parameters_.friction > 0.0) motion = with_friction(wanted, motion);
  const double farthest = motion.translation.norm() + radius_ * motion.rotation.norm();
  motion = blend({}, motion, std::min(1.0, step_ / std::max(farthest, 1e-300)));
  proxy_.position += motion.translation;
  proxy_.orientation = (quaternion(motion.rotation) * proxy_.orientation).normalized();
  return length_of(motion, gyration_);
}

ForceOutput ProxyForce::evaluate(const ForceInput& input) {
  const bool jumped =
      hold_.push == 0.0 && (input.tool.position - proxy_.position).norm() > kMostFreeSteps * step_;
  const bool first = !started_ || jumped;  // a pose so far away is no motion
  if (first) {
    reset();
    proxy_ = input.tool;
    started_ = true;
  }
  const int most_held = first ? kMostFreeSteps : kMostSteps;  // the tool may be deep in something
  int held_steps = 0;
  for (int k = 0; k < kMostFreeSteps && held_steps < most_held; ++k) {
    const double moved = step(input.tool);
    held_steps += hold_.push > 0.0 ? 1 : 0;
    if (moved < kSettled * step_) break;
  }
  if (hold_.push == 0.0) return {Wrench{}, proxy_, 1.0};
  const Motion spring = motion_between(input.tool, proxy_);
  return {{parameters_.stiffness * spring.translation,
           parameters_.stiffness * gyration_ * gyration_ * spring.rotation},
          proxy_,
          hold_.confidence};
}

}  // namespace palpate
