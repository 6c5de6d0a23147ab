/// \file
/// Single-axis motion within limits of jerk, acceleration, velocity and position.
#pragma once

#include <limits>

namespace palpate {

/// Motion limits of one axis. The unit [u] is [m] or [rad].
struct AxisLimits {
  double jerk = 0.0;                                        ///< > 0. Unit: [u/s^3].
  double acceleration = 0.0;                                ///< > 0. Unit: [u/s^2].
  double velocity = 0.0;                                    ///< > 0. Unit: [u/s].
  double lower = -std::numeric_limits<double>::infinity();  ///< of the position. Unit: [u].
  double upper = std::numeric_limits<double>::infinity();
};

/// Motion state of one axis. Unit: [u], [u/s], [u/s^2].
struct AxisState {
  double position = 0.0, velocity = 0.0, acceleration = 0.0;
};

/// Returns the state after `dt` of the stop manoeuvre: the fastest way to rest without reversing the
/// velocity, at jerk -J, 0 and J. A state at rest stays at rest.
AxisState stopping(const AxisState& state, const AxisLimits& limits, double dt);

/// Upper bound of the duration of the stop manoeuvre from within the limits: V / A + 2 A / J. Unit: [s].
double stop_time(const AxisLimits& limits);

/// Returns true if the state and the stop manoeuvre from it are within the limits.
bool can_stop(const AxisState& state, const AxisLimits& limits);

/// Returns the state after `dt` whose acceleration is as near to `wanted` as the limits permit. The new state
/// always satisfies can_stop(): it is found by bisection between the stop manoeuvre, which always does, and
/// the wanted acceleration. A motion that starts within the limits therefore stays within them, for every
/// sequence of `wanted` and `dt`. A state outside of the limits follows the stop manoeuvre until it is
/// inside. \param dt > 0. Unit: [s].
AxisState stepped(const AxisState& state, const AxisLimits& limits, double wanted, double dt);

}  // namespace palpate
