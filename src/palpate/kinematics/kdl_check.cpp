#include <palpate/kinematics/kdl_check.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>

#include <palpate/base/error.h>
#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {
namespace {

/// Tolerance for a chain of some metres: far above rounding. Unit: [m], [rad].
constexpr double kAlike = 1e-9;

KDL::Vector kdl_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame kdl_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()), kdl_of(pose.position)};
}

KDL::Chain kdl_of(const SerialChain& chain) {
  KDL::Chain result;
  for (const ChainJoint& joint : chain.joints) {
    result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_of(joint.origin)));
    const bool slides = joint.type == JointType::kPrismatic;
    result.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), kdl_of(joint.axis),
                                              slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis)));
  }
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_of(chain.tip)));
  return result;
}

}  // namespace

void compare_with_kdl(const SerialChain& chain, const std::string& where) {
  const KDL::Chain theirs = kdl_of(chain);
  KDL::ChainFkSolverPos_recursive solver(theirs);
  ChainKinematics ours(chain);
  const ChainLimits limits(chain);
  KDL::JntArray q(static_cast<unsigned>(chain.size()));
  for (const JointVector& posture : {limits.rest, limits.lower, limits.upper}) {
    q.data = posture;
    KDL::Frame frame;
    solver.JntToCart(q, frame);
    ours.set(posture);
    Pose pose;
    pose.position = {frame.p.x(), frame.p.y(), frame.p.z()};
    Eigen::Quaterniond& o = pose.orientation;
    frame.M.GetQuaternion(o.x(), o.y(), o.z(), o.w());
    const double apart = difference(ours.tip(), pose).norm();
    if (!(apart <= kAlike * (1.0 + pose.position.norm())))
      throw Error("{}: the tip pose differs by {} m from that of KDL; report the file", where, apart);
  }
}

}  // namespace palpate
