#include <palpate/haptics/proxy_force.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// A step of the proxy that is not worth another: a hundredth of a millimetre. Unit: [m].
constexpr double kSettled = 1e-5;

/// Mean radius of gyration of a solid ellipsoid: its moments are m (b^2 + c^2) / 5. Unit: [m].
double gyration_of(const Eigen::Vector3d& semi_axes) { return std::sqrt(2.0 / 15.0) * semi_axes.norm(); }

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

}  // namespace

ProxyForce::ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters)
    : tool_(tool),
      parameters_(parameters),
      kernel_(SurfaceKernel::for_tool(
          tool.semi_axes.minCoeff(),
          parameters.detail.value_or(ProxyParameters::kDetailOfTool * tool.semi_axes.minCoeff()))),
      gyration_(gyration_of(tool.semi_axes)),
      tracker_(index, Precision::kSingle),
      patches_(kernel_) {
  contacts_.contacts.reserve(kRoom);
}

void ProxyForce::reset() {
  started_ = held_ = false;
  patches_.clear();
}

/// Coulomb's law for the proxy: it stays where it is, or as near to that as what presses it on, times the
/// coefficient, cannot hold it. Both `free` and staying keep out of the planes, hence all between them does.
Motion ProxyForce::with_friction(const Motion& wanted, const Motion& free) const {
  const Motion stay = constrained_motion({}, patches(), proxy_.position, gyration_).motion;
  const double pressed = length_of(difference(free, wanted), gyration_);
  const double slide = length_of(difference(stay, free), gyration_);
  const double lag = parameters_.friction * pressed;
  return slide <= lag ? stay : blend(free, stay, lag / slide);
}

double ProxyForce::step(const Pose& target) {
  const Ellipsoid solid = tool_.at(proxy_);
  const Tool larger{tool_.semi_axes.array() + kernel_.reach};
  tracker_.query(larger.at(proxy_), contacts_);
  patches_.update(contacts_.contacts, solid);

  const Motion wanted = motion_between(proxy_, target);
  const ConstrainedMotion free = constrained_motion(wanted, patches(), proxy_.position, gyration_);
  held_ = free.held;
  Motion motion = held_ && parameters_.friction > 0.0 ? with_friction(wanted, free.motion) : free.motion;
  // The farthest that a point of the tool moves.
  const double farthest = motion.translation.norm() + tool_.semi_axes.maxCoeff() * motion.rotation.norm();
  motion = blend({}, motion, std::min(1.0, 0.5 * kernel_.reach / std::max(farthest, 1e-300)));
  proxy_.position += motion.translation;
  proxy_.orientation = (quaternion(motion.rotation) * proxy_.orientation).normalized();
  return length_of(motion, gyration_);
}

ForceOutput ProxyForce::evaluate(const ForceInput& input) {
  const bool jumped =
      !held_ && (input.tool.position - proxy_.position).norm() > kMostFreeSteps * 0.5 * kernel_.reach;
  const bool first = !started_ || jumped;  // a pose so far away is no motion
  if (first) {
    proxy_ = input.tool;
    patches_.clear();
    started_ = true;
  }
  const int most_held = first ? kMostFreeSteps : kMostSteps;  // the tool may be deep in something
  int held_steps = 0;
  for (int k = 0; k < kMostFreeSteps && held_steps < most_held; ++k) {
    const double moved = step(input.tool);
    held_steps += held_ ? 1 : 0;
    if (moved < kSettled) break;
  }
  if (!held_) return {Wrench{}, proxy_};
  const Motion spring = motion_between(input.tool, proxy_);
  return {{parameters_.stiffness * spring.translation,
           parameters_.stiffness * gyration_ * gyration_ * spring.rotation},
          proxy_};
}

}  // namespace palpate
