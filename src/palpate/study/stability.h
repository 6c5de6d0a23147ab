/// \file
/// Contact stability trials of the whole loop with a simulated hand, in virtual time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <palpate/device/profiles.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/scene/scene_filter.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/study/touch_path.h>

namespace palpate {

/// Returns at most `count` distinct places of a scene, chosen as by touch_path(). \throws Error as
/// touch_path().
std::vector<PressPlace> press_places(const SceneIndex& index, const EllipsoidScene& scene, const Tool& tool,
                                     int count, std::uint64_t seed);

/// One trial of a hand with a device: it approaches along PressPlace::inward once the force is on, presses
/// kPress beyond first contact, or as far as takes kForceShare of the device's largest force, rests there for
/// kRest, and slides at kSlideSpeed for kSlide.
struct StabilityTrial {
  const SceneIndex* index = nullptr;
  Tool tool;
  DeviceProfile profile;
  HandProperties hand;
  /// Creates the force model, which searches for contacts through `lookahead` unless that is null.
  std::function<std::unique_ptr<ForceModel>(Lookahead* lookahead)> model;
  double gain = 1.0;          ///< ServoTickOptions::gain
  double worker_delay = 0.0;  ///< delay of the look-ahead contact search; 0: search in the loop. Unit: [s].
  double hold = 0.0;          ///< computation time of a force, then held (ZeroOrderHold); 0: none. Unit: [s].
  /// False: the governor does not stop active behaviour, so that all of its energy is measured.
  bool governed = true;

  static constexpr double kTick = 1e-3;   ///< Unit: [s].
  static constexpr double kPress = 0.01;  ///< Unit: [m].
  static constexpr double kForceShare = 0.5;
  /// Duration of the rest. A heavy hand with a loose grip (0.5 kg with the handle, 100 N/m, 2 N s/m) swings
  /// out with a time constant of 0.5 s; after two seconds that is no longer mistaken for a limit cycle. Unit:
  /// [s].
  static constexpr double kRest = 3.0;
  static constexpr double kSlide = 0.5, kLift = 0.4;  ///< Unit: [s].
  static constexpr double kSlideSpeed = 0.1;          ///< Unit: [m/s].
};

/// State of one tick of a trial.
struct StabilityTick {
  double t = 0.0;      ///< Unit: [s].
  double depth = 0.0;  ///< of the handle along PressPlace::inward, from first contact. Unit: [m].
  double force = 0.0;  ///< sent to the device. Unit: [N].
};

/// Result of a trial.
struct StabilityOutcome {
  double limit_cycle = 0.0;    ///< peak to peak of the handle in the last second of the rest. Unit: [m].
  double port_energy = 0.0;    ///< PassivityController::port_energy(). Unit: [J].
  int contact_changes = 0;     ///< number of times that the force begins or ends
  double rest_force = 0.0;     ///< mean, in that second. Unit: [N].
  Fault fault = Fault::kNone;  ///< the first
  std::vector<StabilityTick> ticks;  ///< all ticks, if requested
};

StabilityOutcome hold_on(const StabilityTrial& trial, const PressPlace& place, bool keeps_ticks = false);

/// Largest limit cycle of a hand that counts as at rest: a fingertip feels about 0.1 mm at the frequencies of
/// a hand. Unit: [m].
inline constexpr double kLimitCycleMax = 0.05e-3;

/// Returns by bisection the largest stiffness with which the hand rests within kLimitCycleMax and the
/// governor does not intervene, for a model with `stiffness` at gain 1. At most kStiffest. Unit: [N/m].
double z_width(const StabilityTrial& trial, const PressPlace& place, double stiffness);
inline constexpr double kStiffest = 5e4;

/// \name An ideal wall
/// A spring on one side of a plane, against which a device without dry friction or encoder steps is pushed
/// with a constant force, so that nothing damps it but the device itself.
/// @{

/// Returns by bisection the stiffness above which a disturbance grows. \param passivity with the
/// PassivityController. Unit: [N/m].
double wall_z_width(const DeviceProfile& profile, double period, bool passivity);

/// Returns the theoretical limit: the largest K for which all eigenvalues of the sampled loop
///
///     m x'' + b x' = -K x_k - B (x_k - x_(k-1)) / T,    held from tick to tick,
///
/// are in the unit circle, with the best B from 0 to `added_damping`. Without any, it is 2 b / T (Colgate and
/// Schenkel 1997) apart from the effect of the mass. Unit: [N/m].
double wall_bound(const DeviceProfile& profile, double period, double added_damping);
/// @}

}  // namespace palpate
