/// \file
/// Serial chains as KDL has them, an independent oracle.
#pragma once

#include <kdl/chain.hpp>

#include <palpate/kinematics/serial_chain.h>

namespace palpate::test {

inline KDL::Vector kdl(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

inline KDL::Frame kdl(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()), kdl(pose.position)};
}

inline Pose pose(const KDL::Frame& frame) {
  Pose pose;
  pose.position = {frame.p.x(), frame.p.y(), frame.p.z()};
  Eigen::Quaterniond& q = pose.orientation;
  frame.M.GetQuaternion(q.x(), q.y(), q.z(), q.w());
  return pose;
}

/// With the inertia of the links, about their centres.
inline KDL::Chain kdl(const SerialChain& chain) {
  KDL::Chain result;
  for (const ChainJoint& joint : chain.joints) {
    result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl(joint.origin)));
    const Eigen::Matrix3d& I = joint.link.inertia;
    const KDL::RigidBodyInertia body(
        joint.link.mass, kdl(joint.link.center),
        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    const auto type = joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
    result.addSegment(
        KDL::Segment(KDL::Joint(KDL::Vector::Zero(), kdl(joint.axis), type), KDL::Frame::Identity(), body));
  }
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl(chain.tip)));
  return result;
}

}  // namespace palpate::test
