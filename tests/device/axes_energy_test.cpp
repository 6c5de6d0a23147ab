// What comes out of a device that senses and shows different axes, late and on uneven ticks.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/device/profiles.h>
#include <palpate/geometry/rotation.h>
#include <palpate/servo/servo_tick.h>
#include <support/force_models.h>
#include <support/noisy_plane.h>
#include <support/uneven_ticks.h>

namespace palpate {
namespace {

constexpr double kHalfLength = 0.02, kHalfWidth = 0.005;

/// Lies along x.
const Tool& rod() {
  static const Tool tool{{kHalfLength, kHalfWidth, kHalfWidth}};
  return tool;
}

/// \name The motion: the gate, strokes, rest, and away. Unit: [s], [m].
/// @{
constexpr double kGate = 0.8, kLeg = 0.5, kStroke = 4.0 * kLeg, kRest = 2.0;
constexpr int kStrokes = 3;
constexpr double kPressing = kGate + kStrokes * kStroke + 2.0 * kLeg, kAway = kPressing + kLeg + kRest,
                 kEnd = kAway + 2.0 * kLeg;
constexpr double kNear = kHalfWidth + 0.001, kHigh = 0.03, kFurther = 0.006;
/// @}

/// From 0 to 1 within a leg that begins then.
double eased_leg(double t, double begin) {
  const double s = std::clamp((t - begin) / kLeg, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

/// A stroke lowers the rod as it lies, turns it upright, 14 mm into the plane, lifts it, and lays it flat. In
/// the end it is pressed, as it is, 6 mm further, rests there and is lifted.
Pose stroke_path(double t) {
  double low = 0.0, upright = 0.0;
  for (int k = 0; k < kStrokes; ++k) {
    const double begin = kGate + k * kStroke;
    low += eased_leg(t, begin) - eased_leg(t, begin + 2.0 * kLeg);
    upright += eased_leg(t, begin + kLeg) - eased_leg(t, begin + 3.0 * kLeg);
  }
  low += eased_leg(t, kPressing - 2.0 * kLeg) - eased_leg(t, kAway);
  upright += eased_leg(t, kPressing - kLeg) - eased_leg(t, kAway + kLeg);
  const double further = eased_leg(t, kPressing) - eased_leg(t, kAway);
  Pose pose;
  pose.position.z() = kHigh + low * (kNear - kHigh) - further * kFurther;
  pose.orientation = rotation_by({0.0, 0.5 * std::numbers::pi * upright, 0.0});
  return pose;
}

/// Of each kind, none or three.
struct Axes {
  const char* name;
  int sensed, actuated;
};
constexpr Axes kAxes[]{{"3 sensed, 3 shown", 0, 0}, {"6 sensed, 3 shown", 3, 0}, {"6 sensed, 6 shown", 3, 3}};

struct AxesTrial {
  std::string profile, model;
  Axes axes;
};

void PrintTo(const AxesTrial& trial, std::ostream* out) {
  *out << trial.profile << ", " << trial.model << ", " << trial.axes.name;
}

struct Outcome {
  double work = 0.0;         ///< most that the motors did on the handle in a stroke. Unit: [J].
  double port_energy = 0.0;  ///< as the controller sees it. Unit: [J].
  double swing = 0.0;        ///< at rest, peak to peak. Unit: [m].
  double pressed = 0.0;      ///< most force. Unit: [N].
  double softest = std::numeric_limits<double>::infinity();  ///< margin
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
};

class AxesEnergy : public testing::TestWithParam<AxesTrial> {
 protected:
  static Outcome run(double delay);
};

Outcome AxesEnergy::run(double delay) {
  const auto& [name, model_name, axes] = GetParam();
  DeviceProfile profile = device_profile(name);
  DeviceCapabilities& can = profile.capabilities;
  can.force_sustained = can.torque_sustained = 0.0;
  can.damping = can.angular_damping = 0.0;  // none is known
  can.sensed.rotation = axes.sensed;
  can.actuated.rotation = axes.actuated;
  can.torque_max = axes.actuated > 0 ? std::max(can.torque_max, 0.1) : 0.0;
  check_capabilities(can);
  profile.plant.damping *= 0.5;
  profile.plant.delay = delay;
  SimulatedDevice device(can, profile.plant, HandProperties{}, stroke_path);
  const std::unique_ptr<ForceModel> model = test::model_called(model_name, test::noisy_plane(), rod());
  ToolTracker tracker(test::noisy_plane(), rod());
  ServoTick loop(device, FeltModel{model.get(), &tracker});
  loop.set_delay(delay);

  Outcome outcome;
  test::UnevenTicks ticks;
  Eigen::AlignedBox3d rest;
  double t = 0.0, before = 0.0;
  int stroke = 0;
  while (t < kEnd) {
    t = ticks.next();
    const TickRecord& now = loop.run(t);
    if (now.margin > 0.0) outcome.softest = std::min(outcome.softest, now.margin);
    if (t > kAway - 1.0 && t < kAway) rest.extend(device.pose().position);
    outcome.pressed = std::max(outcome.pressed, now.sent.force.norm());
    // Flat and high again, where nothing is stored.
    const int over = std::min(kStrokes, static_cast<int>(std::max(0.0, t - kGate) / kStroke));
    if (over > stroke || t >= kEnd) {
      outcome.work = std::max(outcome.work, device.motor_work() - before);
      before = device.motor_work();
      stroke = over;
    }
    outcome.port_energy = now.port_energy;
    outcome.state = now.state;
    outcome.fault = now.fault;
  }
  outcome.swing = rest.diagonal().norm();
  return outcome;
}

TEST_P(AxesEnergy, NoneComesOutOfAStrokeThatTurns) {
  const bool prints = std::getenv("PALPATE_PRINT") != nullptr;
  for (const double delay : {0.0, 2e-3, 5e-3, 10e-3}) {
    const Outcome o = run(delay);
    if (prints) {
      std::printf("| %s | %s | %s | %.0f | %.3f | %.3f | %.3f | %.1f | %.2f |\n", GetParam().profile.c_str(),
                  GetParam().model.c_str(), GetParam().axes.name, 1e3 * delay, 1e3 * o.work,
                  1e3 * o.port_energy, 1e3 * o.swing, o.pressed, o.softest);
    }
    EXPECT_NE(o.state, GovernorState::kStopped) << delay << ": " << traits(o.fault).name;
    EXPECT_LE(o.work, 1e-3) << delay << ", margin " << o.softest;
    EXPECT_LE(o.port_energy, 1e-3) << delay << ", margin " << o.softest;
    EXPECT_LE(o.swing, 0.05e-3) << delay << ", margin " << o.softest;
    EXPECT_GT(o.pressed, 0.05) << "was never pressed";
  }
}

std::vector<AxesTrial> axes_trials() {
  std::vector<AxesTrial> all;
  for (const DeviceProfile& profile : device_profiles())
    for (const char* model : {"proxy", "field"})
      for (const Axes& axes : kAxes) all.push_back({profile.capabilities.name, model, axes});
  return all;
}

INSTANTIATE_TEST_SUITE_P(AllDevices, AxesEnergy, testing::ValuesIn(axes_trials()));

}  // namespace
}  // namespace palpate
