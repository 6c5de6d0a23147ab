#include <palpate/kinematics/serial_chain.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Eigenvalues>

#include <palpate/base/error.h>

namespace palpate {
namespace {

/// Tolerance for rounding in files, of unit norms and of the symmetry of inertias.
constexpr double kUnitTolerance = 1e-6;
/// Largest plausible value: beyond it a unit is wrong. Unit: [m], [kg] and so on.
constexpr double kAbsurd = 1e6;

bool in(double v, double low, double high) { return v >= low && v <= high; }  // false for NaN

void check_link(const LinkInertia& link, const std::string& joint) {
  if (!in(link.mass, 0.0, kAbsurd))
    throw Error("{}: the mass of its link is {}; it must be 0 or more", joint, link.mass);
  if (!link.center.allFinite() || link.center.norm() > kAbsurd)
    throw Error("{}: the centre of mass of its link is not finite, or too far away", joint);
  const Eigen::Matrix3d& I = link.inertia;
  if (!I.allFinite() || (I - I.transpose()).norm() > kUnitTolerance * (1.0 + I.norm()))
    throw Error("{}: the inertia of its link is not finite and symmetric", joint);
  const Eigen::Vector3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I).eigenvalues();
  const double rounding = kUnitTolerance * principal.cwiseAbs().maxCoeff();
  if (principal.minCoeff() < -rounding)
    throw Error("{}: the inertia of its link is negative: {} about one axis", joint, principal.minCoeff());
  // Triangle inequality of the principal moments of inertia.
  if (principal[2] > principal[0] + principal[1] + rounding)
    throw Error("{}: the principal inertias of its link violate the triangle inequality", joint);
}

void check_limits(const ChainJoint& joint, const std::string& named) {
  const JointLimits& l = joint.limits;
  if (!in(l.lower, -kAbsurd, kAbsurd) || !in(l.upper, -kAbsurd, kAbsurd) || !(l.lower < l.upper))
    throw Error("{}: its limits are {} to {}; the lower must be below the upper", named, l.lower, l.upper);
  if (!(l.velocity > 0.0 && l.velocity <= kAbsurd))
    throw Error("{}: its velocity limit is {}; it must be positive", named, l.velocity);
  if (!(l.acceleration > 0.0 && l.acceleration <= kAbsurd))
    throw Error("{}: its acceleration limit is {}; it must be positive", named, l.acceleration);
  if (!(l.effort > 0.0)) throw Error("{}: its effort limit is {}; it must be positive", named, l.effort);
  if (!in(joint.rest, l.lower, l.upper))
    throw Error("{}: its rest position {} is outside of its limits {} to {}", named, joint.rest, l.lower,
                l.upper);
}

bool is_pose(const Pose& pose) {
  return pose.position.allFinite() && pose.position.norm() <= kAbsurd &&
         std::abs(pose.orientation.norm() - 1.0) <= kUnitTolerance;
}

void check_joint(const ChainJoint& joint, const std::string& named) {
  if (!(std::abs(joint.axis.norm() - 1.0) <= kUnitTolerance))
    throw Error("{}: its axis must be a unit vector", named);
  if (!is_pose(joint.origin)) throw Error("{}: its origin is not a valid pose", named);
  check_limits(joint, named);
  check_link(joint.link, named);
}

/// Upper bound of the distance from the axis of joint i to a point of link k, in every posture. \param beyond
/// distance of the point from the frame of link k. Unit: [m].
double reach(const SerialChain& chain, int i, int k, double beyond) {
  double farthest = beyond;
  for (int j = i; j <= k; ++j) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(j)];
    if (j > i) farthest += joint.origin.position.norm();
    if (j > i && joint.type == JointType::kPrismatic)
      farthest += std::max(std::abs(joint.limits.lower), std::abs(joint.limits.upper));
  }
  return farthest;
}

/// Upper bounds of the magnitudes of the joint-space inertia's elements, in every posture.
JointMatrix largest_inertia(const SerialChain& chain, double payload) {
  const int n = chain.size();
  JointMatrix M = JointMatrix::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    const LinkInertia& link = chain.joints[static_cast<std::size_t>(k)].link;
    const bool last = k == n - 1;
    for (int i = 0; i <= k; ++i)
      for (int j = 0; j <= k; ++j) {
        const bool turns_i = chain.joints[static_cast<std::size_t>(i)].type == JointType::kRevolute;
        const bool turns_j = chain.joints[static_cast<std::size_t>(j)].type == JointType::kRevolute;
        const auto lever = [&](int joint, bool turns, double beyond) {
          return turns ? reach(chain, joint, k, beyond) : 1.0;
        };
        const double off = link.center.norm(), tip = chain.tip.position.norm();
        M(i, j) += link.mass * lever(i, turns_i, off) * lever(j, turns_j, off);
        if (turns_i && turns_j) M(i, j) += link.inertia.norm();
        if (last) M(i, j) += payload * lever(i, turns_i, tip) * lever(j, turns_j, tip);
      }
  }
  return M;
}

}  // namespace

ChainLimits::ChainLimits(const SerialChain& chain) {
  const int n = chain.size();
  for (JointVector* v : {&lower, &upper, &velocity, &acceleration, &effort, &rest}) v->resize(n);
  for (int i = 0; i < n; ++i) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(i)];
    lower[i] = joint.limits.lower;
    upper[i] = joint.limits.upper;
    velocity[i] = joint.limits.velocity;
    acceleration[i] = joint.limits.acceleration;
    effort[i] = joint.limits.effort;
    rest[i] = joint.rest;
  }
}

void check_chain(const SerialChain& chain, const std::string& where) {
  if (chain.joints.empty() || chain.size() > kMaxJoints)
    throw Error("{}: the chain has {} movable joints; it must have 1 to {}", where, chain.size(), kMaxJoints);
  if (!is_pose(chain.tip)) throw Error("{}: the tip is not a valid pose", where);
  std::set<std::string> names;
  for (const ChainJoint& joint : chain.joints) {
    const std::string named = fmt::format("{}: joint '{}'", where, joint.name);
    if (joint.name.empty()) throw Error("{}: a joint has no name", where);
    if (!names.insert(joint.name).second) throw Error("{}: two joints have this name", named);
    check_joint(joint, named);
  }
}

JointVector limit_by_effort(SerialChain& chain, double payload) {
  const int n = chain.size();
  const JointMatrix M = largest_inertia(chain, payload);
  const ChainLimits limits(chain);
  double share = 1.0;
  JointVector kept = JointVector::Ones(n);
  for (int i = 0; i < n; ++i) {
    double needed = 0.0;
    for (int j = 0; j < n; ++j) needed += M(i, j) * limits.acceleration[j];
    if (needed > limits.effort[i]) share = std::min(share, limits.effort[i] / needed);
  }
  // The same factor for all joints: a motor may lack effort because of the motion of other joints.
  for (int i = 0; i < n; ++i) {
    chain.joints[static_cast<std::size_t>(i)].limits.acceleration *= share;
    kept[i] = share;
  }
  return kept;
}

}  // namespace palpate
