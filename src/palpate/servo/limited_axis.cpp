#include <palpate/servo/limited_axis.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

/// Tolerance of comparisons with a limit, relative to it.
constexpr double kRounding = 1e-12;
constexpr int kBisections = 12;

struct Phase {
  double jerk = 0.0, time = 0.0;
};
using Phases = std::array<Phase, 3>;

AxisState after(const AxisState& s, double jerk, double t) {
  return {s.position + t * (s.velocity + t * (s.acceleration / 2.0 + t * jerk / 6.0)),
          s.velocity + t * (s.acceleration + t * jerk / 2.0), s.acceleration + t * jerk};
}

/// Sign of the manoeuvre: of the velocity that remains once the acceleration is back at 0; 1 if that is 0.
double direction(const AxisState& s, double J) {
  return s.velocity + s.acceleration * std::abs(s.acceleration) / (2.0 * J) >= 0.0 ? 1.0 : -1.0;
}

/// Phases of a stop, for a positive remaining velocity: acceleration from a down to -p, hold, and up to 0.
/// The two ramps change the speed by (2 p^2 - a^2) / 2 J.
Phases stop_phases(const AxisState& state, const AxisLimits& limits) {
  const double J = limits.jerk, sign = direction(state, J);
  const double v = sign * state.velocity, a = sign * state.acceleration;
  const double most = std::max(limits.acceleration, -a);
  double p = std::sqrt(std::max(0.0, J * v + 0.5 * a * a)), hold = 0.0;
  if (p > most) {
    p = most;
    hold = (v + 0.5 * a * a / J - p * p / J) / p;
  }
  return {{{-sign * J, std::max(0.0, (a + p) / J)}, {0.0, hold}, {sign * J, p / J}}};
}

}  // namespace

AxisState stopping(const AxisState& state, const AxisLimits& limits, double dt) {
  AxisState s = state;
  for (const Phase& phase : stop_phases(state, limits)) {
    const double t = std::min(phase.time, dt);
    s = after(s, phase.jerk, t);
    dt -= t;
    if (dt <= 0.0) return s;
  }
  return {s.position, 0.0, 0.0};
}

double stop_time(const AxisLimits& limits) {
  return limits.velocity / limits.acceleration + 2.0 * limits.acceleration / limits.jerk;
}

bool can_stop(const AxisState& state, const AxisLimits& limits) {
  const double slack = 1.0 + kRounding;
  const double V = limits.velocity * slack;
  if (!(std::abs(state.velocity) <= V && std::abs(state.acceleration) <= limits.acceleration * slack))
    return false;
  const double sign = direction(state, limits.jerk), v = sign * state.velocity, a = sign * state.acceleration;
  const double peak = a > 0.0 ? v + 0.5 * a * a / limits.jerk : v;
  if (peak > V) return false;
  AxisState end = state;
  for (const Phase& phase : stop_phases(state, limits)) end = after(end, phase.jerk, phase.time);
  // If the velocity crosses 0 in the first ramp, the axis reverses.
  double turn = state.position;
  if (v < 0.0) {
    const double t = (a - std::sqrt(std::max(0.0, a * a + 2.0 * limits.jerk * v))) / limits.jerk;
    turn = after(state, -sign * limits.jerk, t).position;
  }
  const double low = std::min({state.position, turn, end.position});
  const double high = std::max({state.position, turn, end.position});
  const auto rounding = [](double bound) { return kRounding * (1.0 + std::abs(bound)); };
  return low >= limits.lower - rounding(limits.lower) && high <= limits.upper + rounding(limits.upper);
}

AxisState stepped(const AxisState& state, const AxisLimits& limits, double wanted, double dt) {
  const AxisState stop = stopping(state, limits, dt);
  const double A = limits.acceleration, reach = limits.jerk * dt;
  const double aim =
      std::clamp(std::clamp(wanted, -A, A), state.acceleration - reach, state.acceleration + reach);
  const auto towards = [&](double acceleration) {
    return after(state, (acceleration - state.acceleration) / dt, dt);
  };
  const AxisState whole = towards(aim);
  if (can_stop(whole, limits)) return whole;
  AxisState best = stop;
  double low = 0.0, high = 1.0;
  for (int k = 0; k < kBisections; ++k) {
    const double share = 0.5 * (low + high);
    const AxisState tried = towards(stop.acceleration + share * (aim - stop.acceleration));
    if (can_stop(tried, limits)) {
      best = tried;
      low = share;
    } else {
      high = share;
    }
  }
  return best;
}

}  // namespace palpate
