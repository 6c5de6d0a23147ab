/// \file
/// Virtual mass and damping that make contact through an admittance-type device stable.
#pragma once

#include <string>

namespace palpate {

/// What an admittance controller renders along one axis: M a + D v = F.
struct AxisAdmittance {
  double mass = 0.0;     ///< M. Unit: [kg], about an axis [kg m^2]. > 0
  double damping = 0.0;  ///< D. Unit: [N s/m], about an axis [N m s/rad]. >= 0
};

/// The loop that an admittance is in, along one axis. About an axis, per radian.
struct AdmittanceLoopModel {
  double contact_stiffness = 0.0;  ///< K_c, of the scene as it is felt. Unit: [N/m]. >= 0
  double contact_damping = 0.0;    ///< B_c, likewise. Unit: [N s/m]. >= 0
  /// Of the hand that holds on: m_h, b_h, k_h. The heaviest and stiffest that is to be expected.
  double hand_mass = 0.0, hand_damping = 0.0, hand_stiffness = 0.0;
  double delay = 0.0;  ///< tau, from the measured force to the motion, half a tick included. Unit: [s]. >= 0
  double lag = 0.0;    ///< T_a, of the drives: 1 / bandwidth. Unit: [s]. >= 0
  double sensor_lag = 0.0;  ///< T_s, of the filter of the force sensor. Unit: [s]. >= 0
  /// Of the gears and belts between drive and handle; 0 takes them to be rigid. Unit: [rad/s], of 1.
  double resonance = 0.0, resonance_damping = 0.1;
};

/// True if the closed loop has no pole in the right half plane:
///
///     M s^2 + D s + H(s) G(s) e^{-s tau} = 0
///     H(s) = K_c + B_c s + (m_h s^2 + b_h s + k_h) / (1 + s T_s)
///     G(s) = 1 / (1 + s T_a) * (1 + 2 z s / w) / (1 + 2 z s / w + s^2 / w^2)
///
/// The scene is felt where the device is measured to be, so that it is as late as the hand. Decided by the
/// argument of the characteristic function, without its denominators, from s = 0 to s = j infinity: it grows
/// by n pi / 2 where none of its zeros is on the right, n being the degree (Mikhailov's criterion, for
/// quasi-polynomials of retarded type: Kolmanovskii and Nosov 1986). Without lags it is of neutral type, and
/// stable only if m_h < M.
bool is_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop);

/// Of least_damping() and least_admittance(): hands and models are known to less than that.
inline constexpr double kDesignMargin = 1.5;

/// By how much K_c, B_c and the hand together may be larger before the loop is at its bound; 0 if it is not
/// stable, at most kMostMargin.
double gain_margin(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop);
inline constexpr double kMostMargin = 1e3;

/// The least damping that makes a mass stable with a gain margin of `margin`, from 1 to there; infinite where
/// none does. With a margin above 1 the loop is also stable once the hand lets go. \param margin >= 1. Unit:
/// [N s/m].
double least_damping(double mass, const AdmittanceLoopModel& loop, double margin = kDesignMargin);

/// Mass and damping on the bound of stability, with a gain margin of `margin`, of which a hand in free space
/// feels least: |j w M + D| is least at w = kFreeMotion. With no contact, no hand and no delay it is zero.
AxisAdmittance least_admittance(const AdmittanceLoopModel& loop, double margin = kDesignMargin);
inline constexpr double kFreeMotion = 12.6;  ///< of a hand that moves about: 2 Hz. Unit: [rad/s].

/// The damping that absorbs what the loop makes out of a contact, whatever hand holds the handle:
///
///     D >= K_c (tau + T_a + T_s) + B_c
///
/// (Colgate and Schenkel 1997, with all that is late in place of half a period). More than a known hand
/// needs; below it ServoTick makes springs softer. Unit: [N s/m].
double passive_damping(const AdmittanceLoopModel& loop);

/// \throws Error, one line that says which bound is broken and by what, if the gain margin is less than
/// `margin`. \param name of the axis, for the message
void require_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop,
                    const std::string& name, double margin = 1.0);

}  // namespace palpate
