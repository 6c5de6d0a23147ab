/// \file
/// Joint plant in MuJoCo, independent of the project's own integrator.
#pragma once

#include <memory>

#include <palpate/device/joint_plant.h>

namespace palpate {

/// The chain as a MuJoCo model: its joints with damping and frictionloss, the drives as actuators with a
/// filter before them, the hand's mass as a body that is welded to the last link, and a force and a torque
/// sensor between the two. Includes centrifugal and Coriolis forces, but neither gravity nor contact.
/// Fourth-order Runge-Kutta in steps of at most kStep; the force of the hand's spring and damper and the
/// speed of the drives are constant over a step. Part of the target palpate::mujoco.
///
/// Allocates in advance(): for simulation and tests. All objects of this class together are used by one
/// thread at a time.
class GiantMujoco final : public JointPlant {
 public:
  /// \param chain checked \throws Error if MuJoCo rejects the model.
  GiantMujoco(const SerialChain& chain, const JointPlantProperties& properties, const GripProperties& grip,
              HandPath path);
  ~GiantMujoco() override;

  void start(const JointVector& q, double t) override;
  /// Keeps its last state once MuJoCo's state is no longer finite.
  void advance(double until, const JointVector& command) override;
  const JointVector& position() const override { return q_; }
  Wrench hand() const override;

  static constexpr double kStep = 2e-4;  ///< Unit: [s].

 private:
  struct Simulation;

  void step(const JointVector& command);
  void tell();

  double bandwidth_;
  JointPlantFigures figures_;
  GripProperties grip_;
  HandPath path_;
  std::unique_ptr<Simulation> simulation_;
  JointVector q_;
  Pose wanted_;  ///< of the hand at the last step
};

}  // namespace palpate
