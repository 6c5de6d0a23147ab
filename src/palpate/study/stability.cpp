#include <palpate/study/stability.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include <palpate/haptics/density_force.h>
#include <palpate/haptics/zero_order_hold.h>
#include <palpate/record/playback.h>
#include <palpate/study/touch_path.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// Times at which the hand begins to approach, arrives, begins to slide, begins to lift off, and ends. Unit:
/// [s].
constexpr double kComes = 0.8, kThere = 1.3, kSlides = kThere + StabilityTrial::kRest;
constexpr double kLifts = kSlides + StabilityTrial::kSlide, kEnds = kLifts + StabilityTrial::kLift;
/// Distance from the surface at which it waits. Unit: [m].
constexpr double kWaits = 0.015;

/// Rises from 0 to 1, with zero slope at both ends.
double smooth_step(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

HandPath path_at(const PressPlace& place, double press) {
  return [=](double t) {
    const double depth = press - (kWaits + press) * (1.0 - smooth_step((t - kComes) / (kThere - kComes)) +
                                                     smooth_step((t - kLifts) / (kEnds - kLifts)));
    const double slid = std::clamp(t - kSlides, 0.0, StabilityTrial::kSlide);
    Pose pose = place.touch;
    pose.position += depth * place.inward + StabilityTrial::kSlideSpeed * slid * place.along;
    return pose;
  };
}

/// Returns the value, going up from `low`, at which `holds` is true for the last time before it is first
/// false, to a hundredth; `low` if it is false there, `most` if it is always true. Values farther up at which
/// it holds again do not count: a loop that saturates its motors looks quiet.
double last_that_holds(double low, double most, const std::function<bool(double)>& holds) {
  constexpr double kStride = 1.3;
  double high = low;
  while (holds(high)) {
    if (high >= most) return most;
    low = high;
    high = std::min(most, kStride * high);
  }
  while (high > 1.01 * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

std::vector<PressPlace> press_places(const SceneIndex& index, const EllipsoidScene& scene, const Tool& tool,
                                     int count, std::uint64_t seed) {
  TouchPathOptions options;
  options.touches = count;
  options.seed = seed;
  const Trajectory path = touch_path(index, scene, tool, options);
  DensityForce any;
  const std::vector<RunRow> rows = play_back(index, tool, any, path);
  std::vector<PressPlace> places;
  for (const Episode& episode : contact_episodes(rows)) {
    PressPlace place{rows[episode.first].tool, {}, {}};
    place.inward = place.touch.orientation * Vector3d::UnitZ();
    const Vector3d way = rows[episode.last].tool.position - place.touch.position;
    const Vector3d across = way - way.dot(place.inward) * place.inward;
    place.along = across.norm() > 0.0 ? Vector3d(across.normalized()) : place.inward.unitOrthogonal();
    places.push_back(place);
  }
  return places;
}

StabilityOutcome hold_on(const StabilityTrial& trial, const PressPlace& place, bool keeps_ticks) {
  Lookahead lookahead;
  Lookahead* const ahead = trial.worker_delay > 0.0 ? &lookahead : nullptr;
  const std::unique_ptr<ForceModel> model = trial.model(ahead);
  ToolTracker contacts(*trial.index, trial.tool, Precision::kDouble, ahead), asked(*trial.index, trial.tool);
  ZeroOrderHold held(*model, model->wants_contacts() ? &asked : nullptr);
  FeltModel felt{model.get(), &contacts};
  std::vector<BackgroundWork*> work{&lookahead};
  if (trial.hold > 0.0) {
    felt.model = &held;
    work = {&held};
  }
  VirtualWorker worker(work, std::max(trial.worker_delay, trial.hold));
  felt.worker = &worker;
  // Limited, since a saturated device is at rest whatever the command.
  const double bearable = StabilityTrial::kForceShare * trial.profile.capabilities.force_max;
  const double press = std::min(StabilityTrial::kPress, bearable / trial.hand.stiffness);
  DeviceCapabilities can = trial.profile.capabilities;
  can.force_sustained = can.torque_sustained = 0.0;  // stability is measured, not heating
  SimulatedDevice device(can, trial.profile.plant, trial.hand, path_at(place, press));
  ServoTickOptions options;
  options.period = StabilityTrial::kTick;
  options.gain = trial.gain;
  options.keeps_passive = false;  // the largest stable stiffness is measured
  if (!trial.governed) {
    options.limits = SafetyLimits::of(trial.profile.capabilities, options.period);
    options.limits->energy_max = std::numeric_limits<double>::infinity();
  }
  ServoTick loop(device, felt, options);

  StabilityOutcome outcome;
  Eigen::AlignedBox3d rest;
  bool pushes = false;
  int resting = 0;
  const auto ticks = static_cast<int>(kEnds / StabilityTrial::kTick);
  for (int k = 0; k < ticks; ++k) {
    const double t = StabilityTrial::kTick * k;
    worker.run_until(t);
    const TickRecord& now = loop.run(t);
    const double force = now.sent.force.norm();
    outcome.port_energy = now.port_energy;
    outcome.contact_changes += (force > 0.0) != pushes ? 1 : 0;
    pushes = force > 0.0;
    if (outcome.fault == Fault::kNone) outcome.fault = now.fault;
    if (t >= kSlides - 1.0 && t < kSlides) {
      rest.extend(device.pose().position);
      outcome.rest_force += force;
      ++resting;
    }
    if (keeps_ticks)
      outcome.ticks.push_back({t, (device.pose().position - place.touch.position).dot(place.inward), force});
  }
  outcome.limit_cycle = rest.diagonal().norm();
  outcome.rest_force /= resting;
  return outcome;
}

double z_width(const StabilityTrial& trial, const PressPlace& place, double stiffness) {
  constexpr double kSoftest = 20.0;
  return last_that_holds(kSoftest, kStiffest, [&](double k) {
    StabilityTrial stiffer = trial;
    stiffer.gain = k / stiffness;
    const StabilityOutcome outcome = hold_on(stiffer, place);
    return outcome.fault == Fault::kNone && outcome.limit_cycle <= kLimitCycleMax;
  });
}

namespace {

/// Force that pushes a device against the wall. Unit: [N].
constexpr double kWallPush = 1.0;
/// Largest swing, in depths of that push: one of more than 2 leaves the wall; this is a little more.
constexpr double kInTouch = 2.2;

/// Peak to peak of a device on a wall of stiffness k, in the 0.3 s from `from` on. Unit: [m].
double wall_swing(const DeviceProfile& profile, double period, bool passivity, double k, double from) {
  constexpr double kWindow = 0.3;
  DeviceProfile ideal = profile;
  ideal.plant.coulomb = ideal.plant.resolution = ideal.plant.turn_resolution = 0.0;
  // Approximates a constant force by a weak spring to a point far inside the wall.
  SimulatedDevice device(ideal.capabilities, ideal.plant, {0.0, 0.0, kWallPush}, [](double t) {
    Pose pose;
    pose.position.x() = t > 0.0 ? -1.0 : 0.0;
    return pose;
  });
  PassivityController controller(period, ideal.capabilities.damping,
                                 passivity ? ideal.capabilities.damping_max : 0.0);
  DeviceReading reading;
  Wrench sent;
  double low = std::numeric_limits<double>::max(), high = -low;
  for (int n = 0; n * period < from + kWindow; ++n) {
    device.read(n * period, reading);
    const double depth = std::max(0.0, -reading.pose.position.x());
    Wrench wanted;
    wanted.force.x() = k * depth;
    sent = controller.correct(wanted, 0.5 * k * depth * depth, sent, reading.pose, period);
    device.write(sent);
    if (n * period < from) continue;
    low = std::min(low, device.pose().position.x());
    high = std::max(high, device.pose().position.x());
  }
  return high - low;
}

/// The largest absolute eigenvalue of the loop of wall_bound().
double growth(const DeviceProfile& profile, double period, double k, double added) {
  const double m = profile.plant.mass, b = profile.plant.damping;
  const double kept = std::exp(-b * period / m), way = (1.0 - kept) * m / b;
  // A force of 1 N that is held for a period displaces the handle by `by` and adds `faster` to its velocity.
  const double by = (period - way) / b, faster = (1.0 - kept) / b;
  const double now = -k - added / period, before = added / period;  // dF/dx_k, dF/dx_(k-1)
  Eigen::Matrix3d loop;
  loop << 1.0 + by * now, way, by * before, faster * now, kept, faster * before, 1.0, 0.0, 0.0;
  return loop.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

double wall_z_width(const DeviceProfile& profile, double period, bool passivity) {
  constexpr double kSoftest = 20.0, kStiff = 1e6;
  return last_that_holds(kSoftest, kStiff, [&](double k) {
    const double early = wall_swing(profile, period, passivity, k, 0.2);
    const double late = wall_swing(profile, period, passivity, k, 2.0);
    return late < early && late < kInTouch * kWallPush / k;
  });
}

double wall_bound(const DeviceProfile& profile, double period, double added_damping) {
  constexpr double kSoftest = 20.0, kStiff = 1e6;
  constexpr int kTried = 60;
  double best = 0.0;
  for (int n = 0; n <= kTried; ++n) {
    const double added = added_damping * n / kTried;
    best = std::max(best, last_that_holds(kSoftest, kStiff, [&](double k) {
                      return growth(profile, period, k, added) <= 1.0;
                    }));
  }
  return best;
}

}  // namespace palpate
