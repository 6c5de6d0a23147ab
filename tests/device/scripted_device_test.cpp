// Everything that a device may do wrong, through a tick and its governor, while a hand leans on a wall.
#include <palpate/device/testing/scripted_device.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/servo/servo_tick.h>
#include <palpate/study/procedural.h>

#include "support/tick.h"
#include "support/wall.h"

namespace palpate {
namespace {

using test::DeviceFault;
using test::kTick;
using test::ScriptedDevice;
using test::ScriptedFault;
using test::Wall;

constexpr double kStiffness = 500.0, kDepth = 8e-3;
/// When the hand is at the wall, and something begins to go wrong. Unit: [s].
constexpr double kPresses = 1.0, kBegin = 2.0;

double eased(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

DeviceCapabilities arm() {
  DeviceCapabilities can;
  can.name = "arm";
  can.force_max = 10.0;
  can.damping_max = 20.0;
  return can;
}

/// A hand that presses kDepth into the wall from kPresses to `lifts`, and again half a second later.
class Leaning {
 public:
  Leaning(std::vector<ScriptedFault> script, double lifts, double moved_at = 1e9, double moved_by = 0.0)
      : device_(arm(), path(lifts, moved_at, moved_by), std::move(script)) {
    open_device(device_, {});
    device_.enable();
    loop_.emplace(device_, FeltModel{&wall_, &contacts_});
  }

  /// \returns the force that the motors show.
  double tick() {
    loop_->run(t_ = kTick * ++count_);
    return device_.shown().force.x();
  }
  double until(double t) {
    double force = 0.0;
    while (t_ + 0.5 * kTick < t) force = tick();
    return force;
  }
  GovernorState state() const { return loop_->governor().state(); }
  Fault fault() const { return loop_->governor().fault(); }
  double t() const { return t_; }
  const ScriptedDevice& device() const { return device_; }

 private:
  static ScriptedDevice::Path path(double lifts, double moved_at, double moved_by) {
    return [=](double t) {
      constexpr double kTakes = 0.05, kAway = 0.01, kAgain = 1.0;
      const double presses =
          eased((t - kPresses) / kTakes) - eased((t - lifts) / kTakes) + eased((t - lifts - kAgain) / kTakes);
      Pose pose;
      pose.position.x() = kAway - (kAway + kDepth) * presses - (t >= moved_at && t < lifts ? moved_by : 0.0);
      pose.position.y() = 1e-6 * std::sin(100.0 * t);  // a hand is never still
      return pose;
    };
  }

  SceneIndex index_{make_scene(*make_surface("sphere"), {}), {}, {}};
  ToolTracker contacts_{index_, Tool{}};
  Wall wall_{kStiffness};
  ScriptedDevice device_;
  std::optional<ServoTick> loop_;
  double t_ = 0.0;
  int count_ = 0;
};

struct Misbehaviour {
  const char* name;
  DeviceFault does;
  Fault fault;
  double notice;  ///< until it is noticed, as documented. Unit: [s].
  double lasts;   ///< Unit: [s].
};

void PrintTo(const Misbehaviour& what, std::ostream* out) { *out << what.name; }

class AScriptedDevice : public testing::TestWithParam<Misbehaviour> {};

TEST_P(AScriptedDevice, ThatFailsShowsNoForceInTimeAndIsFeltAgainThroughTheGate) {
  const auto& [name, does, fault, notice, lasts] = GetParam();
  const double end = kBegin + lasts, lifts = end + 1.0;
  Leaning hand({{kBegin, end, does}}, lifts);
  const double before = hand.until(kBegin - kTick);
  ASSERT_NEAR(before, kStiffness * kDepth, 0.01);
  const double zero = kBegin + notice + traits(fault).fall_time + 2 * kTick;
  bool named = false;
  double most = before + 0.01;
  while (hand.t() < lifts - kTick) {
    const double force = hand.tick();
    ASSERT_LE(force, most) << hand.t();
    if (hand.state() == GovernorState::kFalling) most = force;
    named = named || hand.fault() == fault;
    if (hand.t() >= zero) {
      ASSERT_EQ(force, 0.0) << hand.t();
    }
  }
  EXPECT_TRUE(named);
  EXPECT_EQ(hand.state(), GovernorState::kWaiting) << "it is still in the wall";
  EXPECT_NEAR(hand.until(lifts + 1.2), kStiffness * kDepth, 0.01);
  EXPECT_EQ(hand.state(), GovernorState::kActive);
}

INSTANTIATE_TEST_SUITE_P(
    Everything, AScriptedDevice,
    testing::Values(Misbehaviour{"late", DeviceFault::kLate, Fault::kStalePose, 0.021, 0.3},
                    Misbehaviour{"silent", DeviceFault::kSilent, Fault::kStalePose, 0.021, 0.3},
                    Misbehaviour{"nan", DeviceFault::kNan, Fault::kBadPose, 0.0, 0.3},
                    Misbehaviour{"frozen", DeviceFault::kFrozen, Fault::kFrozenPose, 7.0, 7.3},
                    Misbehaviour{"noisy", DeviceFault::kNoisy, Fault::kJump, 0.005, 0.3},
                    Misbehaviour{"reversed", DeviceFault::kReversed, Fault::kJump, 0.0, 0.3},
                    Misbehaviour{"unplugged", DeviceFault::kUnplugged, Fault::kStalePose, 0.021, 0.3}));

TEST(ScriptedDevice, ThatSaturatesIsFeltAsFarAsItGoes) {
  Leaning hand({{kBegin, 1e9, DeviceFault::kSaturating}}, 4.0);
  hand.until(kBegin - kTick);
  const double force = hand.until(3.0);
  EXPECT_NEAR(force, ScriptedDevice::kSaturated * kStiffness * kDepth, 0.01);
  EXPECT_EQ(hand.state(), GovernorState::kActive);
  hand.until(6.0);
  EXPECT_EQ(hand.state(), GovernorState::kActive) << traits(hand.fault()).name;
}

TEST(ScriptedDevice, ThatIsUnpluggedSaysSo) {
  Leaning hand({{kBegin, kBegin + 0.1, DeviceFault::kUnplugged}}, 4.0);
  hand.until(kBegin + 0.05);
  EXPECT_EQ(hand.device().status(), DeviceStatus::kFault);
  EXPECT_EQ(hand.device().status_text(), "it is not plugged in");
  hand.until(kBegin + 0.15);
  EXPECT_EQ(hand.device().status(), DeviceStatus::kEnabled);
}

// Deep in the wall, after any time: 30 mm farther in are all of the force.
TEST(ScriptedDevice, ThatComesBackElsewhereGivesNoJumpOfForce) {
  for (const double away : {2e-3, 5e-3, 10e-3, 19e-3, 25e-3, 60e-3, 0.3, 1.0}) {
    for (const double by : {0.02, 0.03, 0.1, 0.3}) {
      const double lifts = kBegin + away + 1.0;
      Leaning hand({{kBegin, kBegin + away, DeviceFault::kUnplugged}}, lifts, kBegin, by);
      double before = hand.until(kBegin - kTick);
      while (hand.t() < lifts - kTick) {
        const double force = hand.tick();
        ASSERT_LE(force, before + 1e-9) << away << ", " << by << ", " << hand.t();
        before = force;
      }
      EXPECT_EQ(before, 0.0) << away << ", " << by;
      EXPECT_EQ(hand.state(), GovernorState::kWaiting);
    }
  }
}

}  // namespace
}  // namespace palpate
