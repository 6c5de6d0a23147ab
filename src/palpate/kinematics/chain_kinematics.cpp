#include <palpate/kinematics/chain_kinematics.h>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

Pose moved(const ChainJoint& joint, double q) {
  Pose motion;
  if (joint.type == JointType::kPrismatic)
    motion.position = q * joint.axis;
  else
    motion.orientation = Eigen::AngleAxisd(q, joint.axis);
  return motion;
}

}  // namespace

ChainKinematics::ChainKinematics(const SerialChain& chain)
    : chain_(&chain), links_(chain.joints.size()), axes_(chain.joints.size()), places_(chain.joints.size()) {
  set(JointVector::Zero(chain.size()));
}

void ChainKinematics::set(const JointVector& q) {
  Pose at;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const ChainJoint& joint = chain_->joints[i];
    at = at * joint.origin;
    axes_[i] = at.orientation * joint.axis;
    places_[i] = at.position;
    at = at * moved(joint, q[static_cast<Eigen::Index>(i)]);
    at.orientation.normalize();
    links_[i] = at;
  }
  tip_ = at * chain_->tip;
  tip_.orientation.normalize();
}

Jacobian ChainKinematics::jacobian_at(const Eigen::Vector3d& point, int joints) const {
  Jacobian J = Jacobian::Zero(6, static_cast<Eigen::Index>(links_.size()));
  for (int i = 0; i < joints; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (chain_->joints[k].type == JointType::kPrismatic) {
      J.col(i).head<3>() = axes_[k];
    } else {
      J.col(i).head<3>() = axes_[k].cross(point - places_[k]);
      J.col(i).tail<3>() = axes_[k];
    }
  }
  return J;
}

JointMatrix ChainKinematics::inertia() const {
  const int n = chain_->size();
  JointMatrix M = JointMatrix::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    const LinkInertia& link = chain_->joints[static_cast<std::size_t>(k)].link;
    const Pose& X = this->link(k);
    const Eigen::Matrix3d R = X.orientation.toRotationMatrix();
    const Eigen::Matrix3d I = R * link.inertia * R.transpose();
    const Jacobian J = jacobian_at(X.position + R * link.center, k + 1);
    for (int i = 0; i <= k; ++i) {
      const Eigen::Vector3d momentum = link.mass * J.col(i).head<3>(), spin = I * J.col(i).tail<3>();
      for (int j = 0; j <= i; ++j) M(i, j) += momentum.dot(J.col(j).head<3>()) + spin.dot(J.col(j).tail<3>());
    }
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) M(j, i) = M(i, j);
  return M;
}

Vector6d difference(const Pose& from, const Pose& to) {
  Vector6d d;
  d.head<3>() = to.position - from.position;
  d.tail<3>() = turn_between(from.orientation, to.orientation);
  return d;
}

}  // namespace palpate
