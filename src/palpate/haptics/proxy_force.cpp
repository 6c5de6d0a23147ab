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

/// Time constant of the velocity that damping goes by: a tenth of the shortest time that a hand takes to turn
/// round. Unit: [s].
constexpr double kVelocityFilter = 0.005;

}  // namespace

SurfaceKernel kernel_of(const ToolPart& part, const ProxyParameters& parameters, double extent) {
  const double a_min = part.semi_axes.minCoeff();
  return SurfaceKernel::for_tool(a_min, parameters.detail.value_or(ProxyParameters::kDetailOfTool * a_min),
                                 extent);
}

ToolPart enlarged(const ToolPart& part, const SurfaceKernel& kernel) {
  ToolPart larger = part;
  larger.semi_axes.array() += kernel.reach;
  return larger;
}

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
  obstacles_.planes.reserve(SurfacePatches::kMost * parts_.size());
  obstacles_.properties.reserve(SurfacePatches::kMost * parts_.size());
}

void ProxyForce::reset() {
  started_ = false;
  hold_ = {};
  velocity_.setZero();
  for (Part& part : parts_) part.patches.clear();
}

void ProxyForce::find_obstacles() {
  obstacles_.planes.clear();
  obstacles_.properties.clear();
  for (Part& part : parts_) {
    const Ellipsoid larger = part.larger.at(proxy_);
    part.tracker.query(larger, contacts_);
    surface_.assign(contacts_.contacts, larger, part.patches.kernel());
    part.patches.update(surface_, part.solid.at(proxy_));
    for (const SurfacePatch& patch : part.patches.patches()) {
      const double c = std::max(kLeastConfidence, patch.confidence);
      obstacles_.planes.push_back(
          {patch.normal, (patch.foot - proxy_.position).cross(patch.normal), patch.gap, (1.0 - c) / c, 0.0});
      obstacles_.properties.push_back(properties_at(patch, part.patches.kernel()));
    }
  }
}

ProxyForce::Properties ProxyForce::properties_at(const SurfacePatch& patch,
                                                 const SurfaceKernel& kernel) const {
  const Properties usual{parameters_.stiffness, parameters_.friction, 0.0};
  if (!parameters_.materials || parameters_.materials->empty()) return usual;
  Properties sum{};
  double total = 0.0;
  for (std::size_t i = 0; i < contacts_.contacts.size(); ++i) {
    const Contact& contact = contacts_.contacts[i];
    const Eigen::Vector3d away = (contact.point - patch.foot).cross(patch.normal) / kernel.detail;
    const double w = static_cast<double>(surface_.lane(SurfaceContacts::kWeight)[i]) *
                     std::max(0.0, contact.normal.dot(patch.normal)) * std::exp(-0.5 * away.squaredNorm());
    const Material material = parameters_.materials->of(contact.id, contact.center);
    sum.stiffness += w * material.stiffness.value_or(usual.stiffness);
    sum.friction += w * material.friction.value_or(usual.friction);
    sum.damping += w * material.damping.value_or(usual.damping);
    total += w;
  }
  if (!(total > 0.0)) return usual;
  return {sum.stiffness / total, sum.friction / total, sum.damping / total};
}

ProxyForce::Hold ProxyForce::hold() const {
  Hold sum;
  sum.confidence = 0.0;
  for (std::size_t i = 0; i < obstacles_.planes.size(); ++i) {
    const double push = obstacles_.planes[i].push;
    const Properties& of = obstacles_.properties[i];
    sum.push += push;
    sum.confidence += push / (1.0 + obstacles_.planes[i].compliance);
    sum.properties.stiffness += push * of.stiffness;
    sum.properties.friction += push * of.friction;
    sum.properties.damping += push * of.damping;
  }
  if (sum.push == 0.0) return {};
  const double each = 1.0 / sum.push;
  return {sum.push,
          each * sum.confidence,
          {each * sum.properties.stiffness, each * sum.properties.friction, each * sum.properties.damping}};
}

/// Coulomb's law for the proxy: it stays where it is, or as near to that as what presses it on, times the
/// coefficient, cannot hold it.
Motion ProxyForce::with_friction(const Motion& wanted, const Motion& free) {
  for (MotionConstraint& plane : obstacles_.planes) {
    if (plane.push > 0.0) plane.gap = -plane.along(free);  // as far in or out as without friction
    plane.compliance = 0.0;
  }
  const Motion stay = constrained_motion({}, obstacles_.planes, gyration_);
  const double pressed = length_of(difference(free, wanted), gyration_);
  const double slide = length_of(difference(stay, free), gyration_);
  const double lag = hold_.properties.friction * pressed;
  return slide <= lag ? stay : blend(free, stay, lag / slide);
}

double ProxyForce::step(const Pose& target) {
  find_obstacles();
  const Motion wanted = motion_between(proxy_, target);
  Motion motion = constrained_motion(wanted, obstacles_.planes, gyration_);
  hold_ = hold();
  if (hold_.properties.friction > 0.0) motion = with_friction(wanted, motion);
  const double farthest = motion.translation.norm() + radius_ * motion.rotation.norm();
  motion = blend({}, motion, std::min(1.0, step_ / std::max(farthest, 1e-300)));
  proxy_.position += motion.translation;
  proxy_.orientation = (quaternion(motion.rotation) * proxy_.orientation).normalized();
  return length_of(motion, gyration_);
}

/// At most nothing is left of the push, or twice as much: it begins with none, and never pulls.
double ProxyForce::damped(const Eigen::Vector3d& push) const {
  const double size = push.norm();
  if (hold_.properties.damping == 0.0 || size == 0.0) return 1.0;
  const double outwards = velocity_.dot(push) / size;
  return std::clamp(1.0 - hold_.properties.damping * outwards / size, 0.0, 2.0);
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
  velocity_ += -std::expm1(-input.dt / kVelocityFilter) * (input.velocity.linear - velocity_);
  const int most_held = first ? kMostFreeSteps : kMostSteps;  // the tool may be deep in something
  int held_steps = 0;
  for (int k = 0; k < kMostFreeSteps && held_steps < most_held; ++k) {
    const double moved = step(input.tool);
    held_steps += hold_.push > 0.0 ? 1 : 0;
    if (moved < kSettled * step_) break;
  }
  if (hold_.push == 0.0) return {Wrench{}, proxy_, 1.0};
  const Motion spring = motion_between(input.tool, proxy_);
  const double k = hold_.properties.stiffness, push = damped(k * spring.translation);
  return {{push * k * spring.translation, push * k * gyration_ * gyration_ * spring.rotation},
          proxy_,
          hold_.confidence};
}

}  // namespace palpate
