/// \file
/// Stability of contact through an admittance-type device, and the least stable admittance.
#pragma once

#include <string>

namespace palpate {

/// Admittance rendered along one axis: M a + D v = F.
struct AxisAdmittance {
  double mass = 0.0;     ///< M. Unit: [kg], about an axis [kg m^2]. > 0
  double damping = 0.0;  ///< D. Unit: [N s/m], about an axis [N m s/rad]. >= 0
};

/// Model of the closed loop along one axis; about an axis, per radian.
struct AdmittanceLoopModel {
  double contact_stiffness = 0.0;  ///< K_c, of the scene at the handle. Unit: [N/m]. >= 0
  double contact_damping = 0.0;    ///< B_c, likewise. Unit: [N s/m]. >= 0
  /// m_h, b_h, k_h of the hand that holds the handle: the heaviest and stiffest to be expected.
  double hand_mass = 0.0, hand_damping = 0.0, hand_stiffness = 0.0;
  double delay = 0.0;  ///< tau, from the measured force to the motion, half a tick included. Unit: [s]. >= 0
  double lag = 0.0;    ///< T_a, of the drives: 1 / bandwidth. Unit: [s]. >= 0
  double sensor_lag = 0.0;  ///< T_s, of the filter of the force sensor. Unit: [s]. >= 0
  /// Of the gears and belts between drive and handle; 0 = rigid. Unit: [rad/s], of 1.
  double resonance = 0.0, resonance_damping = 0.1;
};

/// Returns true if the closed loop has no pole in the right half plane:
///
///     M s^2 + D s + H(s) G(s) e^{-s tau} = 0
///     H(s) = K_c + B_c s + (m_h s^2 + b_h s + k_h) / (1 + s T_s)
///     G(s) = 1 / (1 + s T_a) * (1 + 2 z s / w) / (1 + 2 z s / w + s^2 / w^2)
///
/// The force of the scene is evaluated at the measured pose, so that it has the same delay as the hand.
/// Decided by the argument of the characteristic function, without its denominators, from s = 0 to s = j
/// infinity: it grows by n pi / 2, n being the degree, if no zero is in the right half plane (Mikhailov's
/// criterion, for quasi-polynomials of retarded type: Kolmanovskii and Nosov 1986). Without lags it is of
/// neutral type, and stable only if m_h < M.
bool is_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop);

/// Default gain margin of least_damping() and least_admittance(): covers the uncertainty of hands and models.
inline constexpr double kDesignMargin = 1.5;

/// Factor by which K_c, B_c and the hand together may grow before the loop is at its stability bound; 0 if it
/// is not stable, at most kMostMargin.
double gain_margin(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop);
inline constexpr double kMostMargin = 1e3;

/// Least damping with which a mass is stable for all gains from 1 to `margin`; infinite if there is none.
/// With a margin above 1 the loop is also stable after the hand lets go. \param margin >= 1. Unit: [N s/m].
double least_damping(double mass, const AdmittanceLoopModel& loop, double margin = kDesignMargin);

/// Mass and damping at the stability bound, with a gain margin of `margin`, that minimise the impedance |j w
/// M + D| in free space at w = kFreeMotion. Zero without contact, hand and delay.
AxisAdmittance least_admittance(const AdmittanceLoopModel& loop, double margin = kDesignMargin);
inline constexpr double kFreeMotion = 12.6;  ///< of typical free hand motion: 2 Hz. Unit: [rad/s].

/// Damping that absorbs the energy the loop generates in contact, whatever hand holds the handle:
///
///     D >= K_c (tau + T_a + T_s) + B_c
///
/// (Colgate and Schenkel 1997, with the sum of all delays in place of half a period). More than a known hand
/// needs; below it ServoTick lowers the stiffness. Unit: [N s/m].
double passive_damping(const AdmittanceLoopModel& loop);

/// Checks the gain margin. \throws Error, one line that names the violated bound and the cause, if the gain
/// margin is less than `margin`. \param name of the axis, for the message
void require_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop,
                    const std::string& name, double margin = 1.0);

}  // namespace palpate
