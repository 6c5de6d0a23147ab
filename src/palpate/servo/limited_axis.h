/// \file
/// Motion along one axis within limits of jerk, acceleration, velocity and position.
#pragma once

#include <limits>

namespace palpate {

/// Of one axis. The unit [u] is [m] or [rad].
struct AxisLimits {
  double jerk = 0.0;                                        ///< > 0. Unit: [u/s^3].
  double acceleration = 0.0;                                ///< > 0. Unit: [u/s^2].
  double velocity = 0.0;                                    ///< > 0. Unit: [u/s].
  double lower = -std::numeric_limits<double>::infinity();  ///< of the position. Unit: [u].
  double upper = std::numeric_limits<double>::infinity();
};

/// Unit: [u], [u/s], [u/s^2].
struct AxisState {
  double position = 0.0, velocity = 0.0, acceleration = 0.0;
};

/// After `dt` of the stop manoeuvre: the quickest way to rest, without a velocity of the other sign, at
/// jerk -J, 0 and J. From rest it stays there.
AxisState stopping(const AxisState& state, const AxisLimits& limits, double dt);

/// The longest that the stop manoeuvre takes from within the limits: V / A + 2 A / J. Unit: [s].
double stop_time(const AxisLimits& limits);

/// True if the state is within the limits, and so is the stop manoeuvre from there.
bool can_stop(const AxisState& state, const AxisLimits& limits);

/// After `dt` with an acceleration that ends as near to `wanted` as the limits permit. A step is taken only
/// to a state that can_stop(); between that of the stop manoeuvre, which always is one, and the wanted one,
/// by bisection. So what begins within the limits stays within them, for every sequence of `wanted` and `dt`.
/// A state that is not within them goes along the stop manoeuvre until it is. \param dt > 0. Unit: [s].
AxisState stepped(const AxisState& state, const AxisLimits& limits, double wanted, double dt);

}  // namespace palpate
