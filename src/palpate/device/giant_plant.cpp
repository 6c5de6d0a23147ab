#include <palpate/device/giant_plant.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace palpate {

JointPlantFigures::JointPlantFigures(const SerialChain& chain, const JointPlantProperties& p) {
  const ChainLimits limits(chain);
  ChainKinematics at(chain);
  at.set(limits.rest);
  const JointVector M = at.inertia().diagonal();
  stiffness = p.resonance * p.resonance * M;
  damping = 2.0 * p.resonance_damping * p.resonance * M;
  viscous = p.viscous * M;
  coulomb = JointVector::Zero(chain.size());
  for (Eigen::Index i = 0; i < M.size(); ++i)
    if (std::isfinite(limits.effort[i])) coulomb[i] = p.coulomb * limits.effort[i];
}

GiantPlant::GiantPlant(const SerialChain& chain, const JointPlantProperties& properties,
                       const GripProperties& grip, HandPath path)
    : chain_(chain),
      bandwidth_(properties.bandwidth),
      figures_(chain, properties),
      grip_(grip),
      path_(std::move(path)),
      kinematics_(chain_) {
  start(ChainLimits(chain).rest, 0.0);
}

void GiantPlant::start(const JointVector& q, double t) {
  q_ = theta_ = q;
  dq_ = JointVector::Zero(q.size());
  t_ = t;
  kinematics_.set(q);
  wanted_ = path_(t);
  tip_velocity_.setZero();
  hand_ = {};
}

void GiantPlant::step(double h, const JointVector& command) {
  const auto n = q_.size();
  const double kept = std::exp(-bandwidth_ * h);
  const JointVector theta = command + kept * (theta_ - command);
  const Pose wanted = path_(t_ + h);
  const Vector6d hand_velocity = difference(wanted_, wanted) / h, lag = difference(kinematics_.tip(), wanted);
  const Jacobian J = kinematics_.jacobian();
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>().setConstant(grip_.gyration * grip_.gyration);
  const HandProperties& hand = grip_.hand;
  const double grasp = hand.mass + h * hand.damping + h * h * hand.stiffness;
  const Vector6d pull = scale.cwiseProduct(h * (hand.stiffness * lag + hand.damping * hand_velocity));
  const Vector6d momentum = hand.mass * scale.cwiseProduct(tip_velocity_);

  JointMatrix A = inertia_;
  JointVector b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector6d scaled = grasp * scale.cwiseProduct(J.col(i));
    for (Eigen::Index j = 0; j < n; ++j) A(i, j) += scaled.dot(J.col(j));
    const double friction = figures_.viscous[i] + figures_.coulomb[i] / std::max(std::abs(dq_[i]), kCreep);
    A(i, i) += h * (figures_.damping[i] + friction) + h * h * figures_.stiffness[i];
    b[i] =
        h * (figures_.stiffness[i] * (theta[i] - q_[i]) + figures_.damping[i] * (theta[i] - theta_[i]) / h) +
        J.col(i).dot(pull + momentum);
    for (Eigen::Index j = 0; j < n; ++j) b[i] += inertia_(i, j) * dq_[j];
  }
  const JointVector dq = A.llt().solve(b);
  Vector6d tip_velocity = Vector6d::Zero();
  for (Eigen::Index i = 0; i < n; ++i) tip_velocity += dq[i] * J.col(i);
  // Load behind the sensor: the hand's spring and damper, less the inertial force of its mass.
  const Vector6d force = scale.cwiseProduct(hand.stiffness * (lag - h * tip_velocity) +
                                            hand.damping * (hand_velocity - tip_velocity) -
                                            hand.mass * (tip_velocity - tip_velocity_) / h);
  hand_ = {force.head<3>(), force.tail<3>()};
  tip_velocity_ = tip_velocity;
  q_ += 0.5 * h * (dq_ + dq);
  dq_ = dq;
  theta_ = theta;
  kinematics_.set(q_);
  wanted_ = wanted;
  t_ += h;
}

void GiantPlant::advance(double until, const JointVector& command) {
  const auto steps = static_cast<int>(std::ceil((until - t_) / kStep - 1e-6));
  if (steps <= 0) return;
  const double h = (until - t_) / steps;
  inertia_ = kinematics_.inertia();
  for (int k = 0; k < steps; ++k) step(h, command);
  t_ = until;  // exactly, without rounding
}

}  // namespace palpate
