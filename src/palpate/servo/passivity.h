/// \file
/// Passivity observer and controller.
#pragma once

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_pose.h>

namespace palpate {

/// Largest stiffness that a device of damping `damping` renders passively, whatever hand holds it (Colgate
/// and Schenkel 1997, with a loop delay in addition to sampling):
///
///     K (T / 2 + delay) + |B| < b        K_max = (b - |B|) / (T / 2 + delay)
///
/// \param damping b of the device itself. Unit: [N s/m]. \param virtual_damping B of the model. Unit: [N
/// s/m]. \param period T. Unit: [s]. > 0 \param delay from reading to force. Unit: [s]. >= 0 \returns Unit:
/// [N/m]; 0 if no spring is passive.
double passive_stiffness(double damping, double virtual_damping, double period, double delay);

/// A passivity observer and controller at the port between device and model (Hannaford and Ryu 2002). The
/// observer tracks E, the energy stored by the port, and D, the energy it has generated, over every step d =
/// x - x_before:
///
///     W = f_sent . d                          work on the hand; exact, since the force was held
///     Z = (f_sent - f_wanted) . d / 2         part of W that is due to the hold
///     A = min(max(0, Z), b |d|^2 / T)         part of Z that the device's own damping b absorbs in T,
///                                             with b of its own about axes
///     E' = E - W + A,  O = max(0, -E')        output beyond the stored energy
///     E = min(max(0, E'), S)                  at most the energy in the model's spring
///     D += Z - A + O,  D >= 0                 decays within about 20 ms
///
/// with f_sent the force that was held since the last tick, f_wanted the model's force now, and S the energy
/// in the model's spring. The damping is credited only with energy that sampling generates. A spring that
/// winds up by itself generates nothing until that energy is released. A spring of stiffness K generates Z =
/// K |v T|^2 / 2 in each tick, pressing or releasing: as much as damping K T / 2 absorbs, which is Colgate's
/// bound again. The controller adds the damping that absorbs D within a tick, up to `damping_max`; half of
/// its dissipation is counted, in Z, so that twice the missing damping is added: it acts one tick late. For a
/// device with torque output, d and the damping have six components, with rotations scaled by an arm.
///
/// T is the time since the last call, but at least the nominal period: poses that arrive in a burst were not
/// measured in one, and the energy absorbed by the device is not overestimated.
///
/// One object per port and thread; does not allocate.
class PassivityController {
 public:
  /// \param period nominal time between calls. Unit: [s]. > 0 \param damping b. Unit: [N s/m]. \param
  /// damping_max Unit: [N s/m]. 0 = observe only \param arm whose square converts added damping to rotational
  /// damping. 0 = rotations are not damped. Unit: [m]. \param angular_damping b about axes. Unit: [N m
  /// s/rad].
  PassivityController(double period, double damping, double damping_max, double arm = 0.0,
                      double angular_damping = 0.0);

  /// Returns the wrench to send at a pose X_DH in place of `wanted`; wrenches F_H_D. \param stored S at this
  /// pose; infinite if unknown: the port is then only observed. Unit: [J]. \param sent wrench actually sent
  /// after the last call, all later corrections included \param passed time since the last call. Unit: [s].
  Wrench correct(const Wrench& wanted, double stored, const Wrench& sent, const DevicePose& pose,
                 double passed);

  /// D. Unit: [J].
  double excess() const { return excess_; }
  /// Net output: the sum of O since construction. Unit: [J].
  double port_energy() const { return port_energy_; }
  /// Damping added now. Unit: [N s/m].
  double added_damping() const { return added_; }

  /// Resets all but port_energy() to the initial state; the next pose is the first.
  void reset();

 private:
  double period_, damping_, damping_max_, arm_, angular_damping_;
  bool started_ = false;
  DevicePose pose_;
  double excess_ = 0.0, added_ = 0.0;
  double held_ = 0.0, port_energy_ = 0.0;  ///< E, and port_energy(). Unit: [J].
};

}  // namespace palpate
