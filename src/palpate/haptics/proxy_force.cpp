#include <palpate/haptics/proxy_force.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

/// A step of the proxy that is not worth another, as a share of the longest: over so short a way, the surface
/// is as flat as it was taken for, to a hundredth of it, and the next tick goes on from there.
constexpr double kSettled = 0.1;

/// From one pose to another.
Motion motion_between(const Pose& from, const Pose& to) {
  return {to.position - from.position, turn_between(from.orientation, to.orientation)};
}

Motion blend(const Motion& a, const Motion& b, double of_b) {
  return {a.translation + of_b * (b.translation - a.translation),
          a.rotation + of_b * (b.rotation - a.rotation)};
}

/// How much faster than the tool the proxy may move. What the proxy stands on may change in an instant, where
/// a fit finds another patch; the force then changes by 0.05 N a millisecond at 500 N/m, which a hand does
/// not take for an edge, and the proxy does not overshoot where the surface is more bent than it looks. Unit:
/// [m/s].
constexpr double kCatchUp = 0.1;

/// And what is left of that where it has no direction at all.
constexpr double kLeastPurpose = 0.01;

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

ProxyForce::ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters,
                       Lookahead* lookahead)
    : parameters_(parameters),
      gyration_(kTurning * tool.gyration()),
      radius_(tool.radius()),
      step_(std::numeric_limits<double>::infinity()),
      surface_(kRoom) {
  const double extent = index.usual_extent();
  for (const ToolPart& part : tool.parts()) {
    const SurfaceKernel kernel = kernel_of(part, parameters, extent);
    parts_.emplace_back(index, part, kernel, lookahead);
    step_ = std::min(step_, 0.5 * kernel.reach);
  }
  contacts_.contacts.reserve(kRoom);
  obstacles_.planes.reserve(SurfacePatches::kMost * parts_.size());
  obstacles_.properties.reserve(SurfacePatches::kMost * parts_.size());
}

void ProxyForce::reset() {
  started_ = held_ = false;
  hold_ = {};
  reserve_ = kReserve;
  velocity_.setZero();
  direction_.setZero();
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
      const Properties properties = properties_at(patch, part.patches.kernel());
      obstacles_.planes.push_back(
          {patch.normal, patch.foot - proxy_.position, patch.gap, (1.0 - c) / c, properties.friction});
      obstacles_.properties.push_back(properties);
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
    sum.stiffness += push * of.stiffness;
    sum.damping += push * of.damping;
  }
  if (sum.push == 0.0) return {};
  return {sum.push, sum.confidence / sum.push, sum.stiffness / sum.push, sum.damping / sum.push};
}

namespace {

/// Product of motions whose squared length is length_of()^2.
double product(const Motion& a, const Motion& b, double gyration) {
  return a.translation.dot(b.translation) + gyration * gyration * a.rotation.dot(b.rotation);
}

/// The largest share s of `motion` in [0, 1] with |wanted - s motion| <= stretch; 0 if there is none.
double share_within(const Motion& wanted, const Motion& motion, double stretch, double gyration) {
  const double a = product(motion, motion, gyration), b = product(wanted, motion, gyration);
  const double c = product(wanted, wanted, gyration) - stretch * stretch;
  const double root = b * b - a * c;
  if (a == 0.0) return 1.0;
  return root < 0.0 ? 0.0 : std::clamp((b + std::sqrt(root)) / a, 0.0, 1.0);
}

}  // namespace

double ProxyForce::step(const Pose& target, double longest, double stretch) {
  find_obstacles();
  const Motion wanted = motion_between(proxy_, target);
  Motion motion = constrained_motion(wanted, obstacles_.planes, gyration_);
  const Hold held = hold();
  held_ = held.push > 0.0;
  if (held_) hold_ = held;  // what is let go slowly stays what it was
  const double farthest = motion.translation.norm() + radius_ * motion.rotation.norm();
  const double length = length_of(motion, gyration_);
  const double share = std::min({1.0, step_ / std::max(farthest, 1e-300), longest / std::max(length, 1e-300),
                                 share_within(wanted, motion, stretch, gyration_)});
  if (!held_ && share == 1.0) {
    proxy_ = target;  // not to rounding
  } else {
    motion = blend({}, motion, share);
    proxy_.position += motion.translation;
    proxy_.orientation = (rotation_by(motion.rotation) * proxy_.orientation).normalized();
  }
  return share * length;
}

/// At most nothing is left of the push, or twice as much: it begins with none, and never pulls.
double ProxyForce::damped(const Eigen::Vector3d& push) const {
  const double size = push.norm();
  if (hold_.damping == 0.0 || size == 0.0) return 1.0;
  const double outwards = velocity_.dot(push) / size;
  return std::clamp(1.0 - hold_.damping * outwards / size, 0.0, 2.0);
}

/// Less where the proxy goes to and fro, as between patches that come and go in turn: it then settles.
double ProxyForce::catch_up() const { return kCatchUp * std::max(kLeastPurpose, direction_.squaredNorm()); }

void ProxyForce::remember(const Eigen::Vector3d& moved) {
  const double way = moved.norm();
  if (way == 0.0) return;
  const double forgotten = -std::expm1(-way / step_);
  direction_ += forgotten * (moved / way - direction_);
}

/// What the spring has lost by the proxy's own motion fills the reserve, what it has gained empties it. Of
/// what it was stretched by the tool's motion, k |d|^2 / 2 is no work of the hand's, which felt the force of
/// before all the way: to a tool that slides, it would be a gift in every tick.
void ProxyForce::reserve(double slack, double of_tool, double length) {
  const double lost = std::max(0.0, slack * slack - of_tool * of_tool - length * length);
  const double gained = std::max(0.0, length * length - slack * slack);
  reserve_ = std::clamp(reserve_ + 0.5 * hold_.stiffness * (lost - gained), 0.0, kReserve);
}

ForceOutput ProxyForce::evaluate(const ForceInput& input) {
  const bool jumped = !held_ && (input.tool.position - proxy_.position).norm() > kMostFreeSteps * step_;
  const bool first = !started_ || jumped;  // a pose so far away is no motion
  if (first) {
    reset();
    proxy_ = tool_ = input.tool;
    started_ = true;
  }
  velocity_ += -std::expm1(-input.dt / kVelocityFilter) * (input.velocity.linear - velocity_);
  // Where the tool starts in something, it comes out at once.
  const double of_tool = length_of(motion_between(tool_, input.tool), gyration_);
  double way = first ? std::numeric_limits<double>::infinity() : of_tool + catch_up() * input.dt;
  tool_ = input.tool;
  const Eigen::Vector3d before = proxy_.position;
  // The spring as it is before the proxy moves, and how much longer it may get.
  const double slack = length_of(motion_between(proxy_, input.tool), gyration_);
  const double stretch = first || hold_.stiffness == 0.0
                             ? std::numeric_limits<double>::infinity()
                             : std::sqrt(slack * slack + 2.0 * reserve_ / hold_.stiffness);
  const int most_held = first ? kMostFreeSteps : kMostSteps;
  int held_steps = 0;
  for (int k = 0; k < kMostFreeSteps && held_steps < most_held && way > 0.0; ++k) {
    const double moved = step(input.tool, way, stretch);
    way -= moved;
    held_steps += held_ ? 1 : 0;
    if (moved < kSettled * step_) break;
  }
  remember(proxy_.position - before);
  const Motion spring = motion_between(input.tool, proxy_);
  const double length = length_of(spring, gyration_);
  if (!first) reserve(slack, of_tool, length);
  if (length == 0.0) return {Wrench{}, proxy_, 1.0, reserve_};
  const double k = hold_.stiffness, push = damped(k * spring.translation);
  return {{push * k * spring.translation, push * k * gyration_ * gyration_ * spring.rotation},
          proxy_,
          hold_.confidence,
          0.5 * k * length * length + reserve_,
          k};
}

}  // namespace palpate
