/// \file
/// Assembly of a simulated room-scale device: chain, plant, admittance and loop.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include <palpate/device/giant_device.h>
#include <palpate/kinematics/serial_chain.h>
#include <palpate/servo/admittance_loop.h>

namespace palpate {

/// User-selectable parameters of a GiantDevice held by a hand.
struct GiantSetup {
  SerialChain chain;    ///< checked; see driven_chain()
  HandProperties hand;  ///< that holds the handle
  /// Virtual mass of the handle in free space, the same along all axes. Unit: [kg].
  double virtual_mass = kVirtualMass;
  /// Virtual damping, likewise; if unset, kVirtualDamping or the least damping with stable and passive
  /// contact, whichever is more. Unit: [N s/m].
  std::optional<double> virtual_damping = {};
  double contact_stiffness = 0.0;  ///< of the scene at the handle. Unit: [N/m].
  double period = 1e-3;            ///< of the loop. Unit: [s].

  static constexpr double kVirtualMass = 1.5, kVirtualDamping = 12.0;
};

/// Returns the chain with accelerations limited by its motors' effort, with the mass of the hand at the TCP.
SerialChain driven_chain(SerialChain chain, const HandProperties& hand);

/// Returns the loop model of chain, drives, hand and contact along an axis, for an AdmittanceLoop.
AdmittanceLoopModel loop_of(const GiantSetup& setup);

/// Returns the admittance of the handle in free space.
Admittance admittance_of(const GiantSetup& setup);

/// Creates the device on `plant`, which was created for the same chain, with its joints at their rest
/// positions. \param seed of the noise of the force sensor \throws Error, which names axis and bound, if the
/// admittance is not stable.
std::unique_ptr<AdmittanceLoop> make_giant_loop(const GiantSetup& setup, std::unique_ptr<JointPlant> plant,
                                                std::uint64_t seed = 1);

/// Returns the pose of the handle with the joints at rest. Base's frame.
Pose rest_of_handle(const SerialChain& chain);

/// Returns the reachable range of the handle of giant_chain() without rotation. Base's frame. Unit: [m].
Eigen::AlignedBox3d giant_reach();

}  // namespace palpate
