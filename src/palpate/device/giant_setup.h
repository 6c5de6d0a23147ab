/// \file
/// A simulated room-scale device, put together: chain, plant, admittance and loop.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include <palpate/device/giant_device.h>
#include <palpate/kinematics/serial_chain.h>
#include <palpate/servo/admittance_loop.h>

namespace palpate {

/// What a person chooses of a GiantDevice in a hand.
struct GiantSetup {
  SerialChain chain;    ///< checked; see driven_chain()
  HandProperties hand;  ///< that holds the handle
  /// Of the handle in free space, the same along all axes. Unit: [kg].
  double virtual_mass = kVirtualMass;
  /// Likewise; unset: kVirtualDamping, or the least with which contact is stable and passive, if that is
  /// more. Unit: [N s/m].
  std::optional<double> virtual_damping = {};
  double contact_stiffness = 0.0;  ///< of the scene as it is felt. Unit: [N/m].
  double period = 1e-3;            ///< of the loop. Unit: [s].

  static constexpr double kVirtualMass = 1.5, kVirtualDamping = 12.0;
};

/// The chain with accelerations that its motors have effort for, with the mass of the hand at the TCP.
SerialChain driven_chain(SerialChain chain, const HandProperties& hand);

/// What chain, drives, hand and contact are to an AdmittanceLoop, along an axis.
AdmittanceLoopModel loop_of(const GiantSetup& setup);

/// What the handle is in free space.
Admittance admittance_of(const GiantSetup& setup);

/// The device on `plant`, which was made with the same chain, with its handle where the joints rest.
/// \param seed of the noise of its force sensor \throws Error, which names axis and bound, if the admittance
/// is not stable.
std::unique_ptr<AdmittanceLoop> make_giant_loop(const GiantSetup& setup, std::unique_ptr<JointPlant> plant,
                                                std::uint64_t seed = 1);

/// Where the handle is while the joints rest. Base's frame.
Pose rest_of_handle(const SerialChain& chain);

/// Where the handle of giant_chain() can be without being turned. Base's frame. Unit: [m].
Eigen::AlignedBox3d giant_reach();

}  // namespace palpate
