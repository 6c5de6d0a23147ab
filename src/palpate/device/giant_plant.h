/// \file
/// Joint plant with the project's own integrator.
#pragma once

#include <palpate/device/joint_plant.h>
#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {

/// Semi-implicit steps of at most kStep: springs, dampers and friction of the joints and of the hand are
/// implicit, so that every stiffness is stable; J(q) is taken at the beginning of the step, M(q) at the last
/// call of advance(). Centrifugal and Coriolis forces of the links are left out: walking and reaching turn
/// the joints at about 1 rad/s, where these forces are a few N. Dry friction is viscous below kCreep, and so
/// does not stick.
///
/// Does not allocate after construction.
class GiantPlant final : public JointPlant {
 public:
  /// \param chain checked \param path whatever it refers to must outlive the object
  GiantPlant(const SerialChain& chain, const JointPlantProperties& properties, const GripProperties& grip,
             HandPath path);

  void start(const JointVector& q, double t) override;
  void advance(double until, const JointVector& command) override;
  const JointVector& position() const override { return q_; }
  Wrench hand() const override { return hand_; }

  static constexpr double kStep = 1e-4;   ///< Unit: [s].
  static constexpr double kCreep = 1e-4;  ///< Unit: [m/s], [rad/s].

 private:
  void step(double h, const JointVector& command);

  SerialChain chain_;
  double bandwidth_;
  JointPlantFigures figures_;
  GripProperties grip_;
  HandPath path_;
  ChainKinematics kinematics_;
  JointMatrix inertia_;  ///< of the chain
  JointVector theta_, q_, dq_;
  double t_ = 0.0;
  Pose wanted_;                               ///< of the hand, at t_
  Vector6d tip_velocity_ = Vector6d::Zero();  ///< at the end of the last step
  Wrench hand_;
};

}  // namespace palpate
