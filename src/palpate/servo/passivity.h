/// \file
/// Keeping what is felt from pushing by itself.
#pragma once

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_pose.h>

namespace palpate {

/// How stiff a spring may be, shown through a device of damping `damping`, so that it is passive whatever
/// hand holds it (Colgate and Schenkel 1997, with a delay of the loop besides that of sampling):
///
///     K (T / 2 + delay) + |B| < b        K_max = (b - |B|) / (T / 2 + delay)
///
/// \param damping b of the device itself. Unit: [N s/m]. \param virtual_damping B of the model. Unit: [N
/// s/m]. \param period T. Unit: [s]. > 0 \param delay from reading to force. Unit: [s]. >= 0 \returns Unit:
/// [N/m]; 0 where no spring is.
double passive_stiffness(double damping, double virtual_damping, double period, double delay);

/// A passivity observer and controller at the port between device and model (Hannaford and Ryu 2002). The
/// observer keeps E, what the port has stored, and D, what it has made, over every step d = x - x_before:
///
///     W = f_sent . d                          work on the hand, exact, since the force was held on the way
///     Z = (f_sent - f_wanted) . d / 2         of that, what is because it was held
///     A = min(max(0, Z), b |d|^2 / T)         of that, what the device's own damping b absorbs in the time T
///     E' = E - W + A,  O = max(0, -E')        put out beyond what was stored
///     E = min(max(0, E'), S)                  no more than the model's spring holds
///     D += Z - A + O,  D >= 0                 forgotten within some 20 ms
///
/// with f_sent the force that was held since the last tick, f_wanted the model's now, and S the energy in the
/// model's spring. The damping may absorb what sampling makes, and nothing else. A spring that winds up by
/// itself has made nothing until that comes out. A spring of stiffness K makes Z = K |v T|^2 / 2 in each
/// tick, pressing or letting go: as much as damping K T / 2 absorbs, which is Colgate's bound again. The
/// controller adds the damping that absorbs D within a tick, up to `damping_max`; half of what that damping
/// takes is counted, in Z, so that there is twice as much of it as is lacking: it comes a tick late. Where
/// the device shows a torque, d and what damps have six components, of which turns count times an arm.
///
/// T is the time that has passed since the last call, but no less than the promised one: poses that come in a
/// bunch were not made in one, and what the device absorbs is not overstated.
///
/// One object a port and thread; takes nothing from the heap.
class PassivityController {
 public:
  /// \param period between calls, as promised. Unit: [s]. > 0 \param damping b. Unit: [N s/m]. \param
  /// damping_max Unit: [N s/m]. 0: only observes \param arm that makes damping one of turns: by its square.
  /// 0: turns are not damped. Unit: [m].
  PassivityController(double period, double damping, double damping_max, double arm = 0.0);

  /// What to send at a pose X_DH, in place of `wanted`; wrenches F_H_D. \param stored S at this pose;
  /// infinite if nobody knows: it is then only observed. Unit: [J]. \param sent what was sent at the last
  /// call, by whoever was last to change it \param passed since that. Unit: [s].
  Wrench correct(const Wrench& wanted, double stored, const Wrench& sent, const DevicePose& pose,
                 double passed);

  /// D. Unit: [J].
  double excess() const { return excess_; }
  /// The sum of O, ever. Unit: [J].
  double put_out() const { return put_out_; }
  /// That is added now. Unit: [N s/m].
  double added_damping() const { return added_; }

  /// As at the beginning, with the next pose the first, but for put_out().
  void reset();

 private:
  double period_, damping_, damping_max_, arm_;
  bool started_ = false;
  DevicePose pose_;
  double excess_ = 0.0, added_ = 0.0;
  double held_ = 0.0, put_out_ = 0.0;  ///< E, and what put_out() tells. Unit: [J].
};

}  // namespace palpate
