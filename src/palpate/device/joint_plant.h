/// \file
/// Simulated mechanics of a serial device held by a hand: interface and parameters.
#pragma once

#include <palpate/device/simulated_device.h>
#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// Drives, gears and friction of all joints, in quantities independent of the size of a joint: M is a joint's
/// inertia in the rest posture.
struct JointPlantProperties {
  double bandwidth = 190.0;  ///< bandwidth of the drives' position control: 1 / T_a. Unit: [rad/s]. > 0
  /// Of the compliance of gears and belts: stiffness M w^2, damping 2 z w M. Unit: [rad/s], of 1. > 0
  double resonance = 250.0, resonance_damping = 0.2;
  double viscous = 0.2;  ///< friction at the joint, over M. Unit: [1/s]. >= 0
  /// Dry friction at the joint, over the effort limit; none without that limit. Friction of motors and gears
  /// is on the drive side of the compliance, where position control overcomes it. >= 0
  double coulomb = 0.0005;
};

/// These properties for each joint of a chain. Shape of each: [joints].
struct JointPlantFigures {
  /// \param hand that holds the handle at rest, whose mass counts
  JointPlantFigures(const SerialChain& chain, const JointPlantProperties& properties);
  JointVector stiffness;  ///< Unit: [N/m] or [N m/rad].
  JointVector damping;    ///< Unit: [N s/m] or [N m s/rad].
  JointVector viscous;    ///< Unit: likewise.
  JointVector coulomb;    ///< Unit: [N] or [N m].
};

/// The hand that holds the handle: a mass that moves with it, and a spring and a damper to its target pose.
/// In rotation about the TCP the same values times `gyration` squared apply.
struct GripProperties {
  HandProperties hand;
  double gyration = 0.05;  ///< Unit: [m]. > 0
};

/// The mechanics of a chain whose joints follow commands, with a hand at the TCP:
///
///     theta' = w (command - theta)                                                 drives
///     M(q) q'' = K (theta - q) + B (theta' - q') - d q' - c sign(q') + J^T F        joints
///     F = k (x_hand - x) + b (x_hand' - x') - m x''                                 hand, at the sensor
///
/// Weight is balanced by springs and counterweights. One thread.
class JointPlant {
 public:
  JointPlant() = default;
  virtual ~JointPlant() = default;
  JointPlant(const JointPlant&) = delete;
  JointPlant& operator=(const JointPlant&) = delete;

  /// Starts at rest at `q`. \param q Shape: [joints].
  virtual void start(const JointVector& q, double t) = 0;
  /// Advances to `until` while the drives follow `command`. \param until Unit: [s].
  virtual void advance(double until, const JointVector& command) = 0;

  virtual const JointVector& position() const = 0;
  /// F: wrench of the hand on the handle at the sensor. Base's frame, torque about the TCP.
  virtual Wrench hand() const = 0;
};

}  // namespace palpate
