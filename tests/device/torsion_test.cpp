// A long tool that is turned into a surface, with devices that turn the hand back.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/device/profiles.h>
#include <palpate/geometry/rotation.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/servo/servo_tick.h>
#include <support/giant_trial.h>
#include <support/noisy_plane.h>
#include <support/uneven_ticks.h>

namespace palpate {
namespace {

/// A rod along x, its handle in the middle, above a plane into which it turns one end.
constexpr double kRodRadius = 0.006, kRodHeight = 0.03, kRodDepth = 0.015;
/// The motion: the gate, the turn, and the rest. Unit: [s].
constexpr double kTurnBegins = 0.8, kTurnTakes = 0.7, kRestBegins = 4.0, kRestEnds = 5.0;
/// The virtual damping of the giant slows a soft hand down.
constexpr double kGiantWaitsLonger = 3.0;
/// Radius of a grip, at which a turn is felt as a way. Unit: [m].
constexpr double kGripRadius = 0.03;

Eigen::Quaterniond turned_rod(double half_length, double t) {
  const double s = std::clamp((t - kTurnBegins) / kTurnTakes, 0.0, 1.0);
  const double angle = std::asin((kRodHeight + kRodDepth) / half_length);
  return rotation_by({0.0, angle * s * s * (3.0 - 2.0 * s), 0.0});
}

Tool long_rod(double half_length) { return Tool{{half_length, kRodRadius, kRodRadius}}; }

/// As LiveSystem makes it for a device.
std::unique_ptr<ForceModel> model_for(const DeviceCapabilities& can, const std::string& name,
                                      const Tool& tool, double stiffness) {
  if (name == "field") return std::make_unique<FieldForce>(tool, FieldParameters{stiffness});
  ProxyParameters parameters;
  parameters.stiffness = stiffness;
  parameters.arm_max = ServoTick::longest_arm(can, stiffness, 1.0 / can.rate);
  return std::make_unique<ProxyForce>(test::noisy_plane(), tool, parameters);
}

/// How far a handle swings to and fro at rest, within a 20th of a second: its path less the way between both
/// ends. A stiffness that yields, as ticks come later, is no limit cycle.
class Swing {
 public:
  explicit Swing(double begin) : begin_(begin) {}
  void add(double t, const Pose& pose) {
    if (t < begin_) return;
    while (!last_.empty() && last_.front().t < t - 0.05) last_.pop_front();
    const double path = last_.empty() ? 0.0 : last_.back().path + way(last_.back().pose, pose);
    last_.push_back({t, pose, path});
    most_ = std::max(most_, path - last_.front().path - way(last_.front().pose, pose));
  }
  double most() const { return most_; }  ///< Unit: [m].

 private:
  struct Sample {
    double t;
    Pose pose;
    double path;  ///< so far. Unit: [m].
  };
  static double way(const Pose& from, const Pose& to) {
    return std::hypot((to.position - from.position).norm(),
                      kGripRadius * turn_between(from.orientation, to.orientation).norm());
  }
  std::deque<Sample> last_;
  double begin_, most_ = 0.0;
};

struct TurnOutcome {
  double swing = 0.0;                                        ///< Unit: [m].
  double port_energy = 0.0;                                  ///< Unit: [J].
  double torque = 0.0;                                       ///< the largest. Unit: [N m].
  double softest = std::numeric_limits<double>::infinity();  ///< margin
  Fault fault = Fault::kNone;

  void add(const TickRecord& now) {
    if (now.margin > 0.0) softest = std::min(softest, now.margin);
    torque = std::max(torque, now.sent.torque.norm());
    port_energy = now.port_energy;
    if (fault == Fault::kNone) fault = now.fault;
  }
  void print(const std::string& what) const {
    if (std::getenv("PALPATE_PRINT") == nullptr) return;
    std::printf("%s: swing %.4f mm, energy %.3f mJ, torque %.3f N m, margin %.2f, %s\n", what.c_str(),
                1e3 * swing, 1e3 * port_energy, torque, softest, traits(fault).name.data());
  }
};

struct TurnTrial {
  std::string model;
  double half_length;
};

void PrintTo(const TurnTrial& trial, std::ostream* out) {
  *out << trial.model << ", half a rod of " << trial.half_length << " m";
}

class Torsion : public testing::TestWithParam<TurnTrial> {};

TurnOutcome turn_lambda(const TurnTrial& trial, const HandProperties& hand, double delay) {
  DeviceProfile profile = device_profile("lambda.7");
  DeviceCapabilities& can = profile.capabilities;
  can.force_sustained = can.torque_sustained = 0.0;
  can.damping = can.angular_damping = 0.0;  // none is known
  profile.plant.damping *= 0.5;
  profile.plant.delay = delay;
  const Tool tool = long_rod(trial.half_length);
  const HandPath path = [&](double t) {
    return Pose{{0.0, 0.0, kRodHeight}, turned_rod(trial.half_length, t)};
  };
  SimulatedDevice device(can, profile.plant, hand, path);
  const std::unique_ptr<ForceModel> model = model_for(can, trial.model, tool, 500.0);
  ToolTracker tracker(test::noisy_plane(), tool);
  ServoTick loop(device, FeltModel{model.get(), &tracker});
  loop.set_delay(delay);
  TurnOutcome outcome;
  Swing swing(kRestBegins);
  test::UnevenTicks ticks;
  for (double t = ticks.next(); t < kRestEnds; t = ticks.next()) {
    outcome.add(loop.run(t));
    swing.add(t, device.pose());
  }
  outcome.swing = swing.most();
  return outcome;
}

// Whoever holds it, however late the torque: it comes to rest, or is softened until it does. On the end of a
// rod FieldForce is steeper than its stiffness (FieldDepth): a late force may swing there.
TEST_P(Torsion, OfADesktopDeviceRests) {
  const bool is_field = GetParam().model == "field";
  for (const HandProperties& hand : {HandProperties{0.05, 1.0, 100.0}, {}, {0.3, 10.0, 1000.0}}) {
    for (const double delay : {0.0, 2e-3, 5e-3, 10e-3}) {
      const TurnOutcome o = turn_lambda(GetParam(), hand, delay);
      const std::string what =
          std::to_string(hand.stiffness) + " N/m, delay " + std::to_string(1e3 * delay) + " ms";
      o.print(testing::PrintToString(GetParam()) + ", " + what);
      EXPECT_EQ(o.fault, Fault::kNone) << what << ": " << traits(o.fault).name;
      EXPECT_LE(o.swing, is_field ? 2e-3 : 0.05e-3) << what;
      EXPECT_LE(o.port_energy, is_field ? 5e-3 : 1e-3) << what;
      EXPECT_GT(o.torque, 1e-3) << what << ": was not felt";
    }
  }
}

TurnOutcome turn_giant(const TurnTrial& trial, const HandProperties& hand, double stiffness) {
  test::GiantTrial giant;
  giant.hand = hand;
  giant.properties.sensor.noise = giant.properties.sensor.torque_noise = 0.0;
  giant.map.offset = Eigen::Vector3d(0.0, 0.0, kRodHeight) - test::giant_home().position;
  giant.map.tool = test::giant_home().orientation.conjugate();
  giant.admittance.damping.setConstant(40.0);
  const HandPath path = [&](double t) {
    Pose pose = test::giant_home();
    pose.orientation = turned_rod(trial.half_length, t - test::kGiantWaits + kTurnBegins) * pose.orientation;
    return pose;
  };
  GiantDevice device(test::giant(), test::own_plant(giant.properties.drives, {hand, 0.05}, path),
                     giant.properties, test::giant_home());
  AdmittanceLoop loop(device, test::trial_options(giant));
  const Tool tool = long_rod(trial.half_length);
  const std::unique_ptr<ForceModel> model = model_for(loop.capabilities(), trial.model, tool, stiffness);
  ToolTracker tracker(test::noisy_plane(), tool);
  ServoTickOptions options;
  options.map = giant.map;
  ServoTick tick(loop, {model.get(), &tracker}, options);
  TurnOutcome outcome;
  Swing swing(kRestBegins + kGiantWaitsLonger);
  for (int k = 0; k * test::kTick < kRestEnds + kGiantWaitsLonger; ++k) {
    outcome.add(tick.run(k * test::kTick));
    swing.add(k * test::kTick, device.pose());
    if (outcome.fault == Fault::kNone) outcome.fault = loop.governor().fault();
  }
  outcome.swing = swing.most();
  return outcome;
}

class RoomScaleTorsion : public testing::TestWithParam<double> {};

TEST_P(RoomScaleTorsion, Rests) {
  for (const std::size_t hand : {0, 2, 4}) {
    for (const double stiffness : {500.0, 2000.0}) {
      const TurnTrial trial{"proxy", GetParam()};
      const TurnOutcome o = turn_giant(trial, test::kOperators.at(hand), stiffness);
      const std::string what =
          std::to_string(stiffness) + " N/m, hand " + std::to_string(test::kOperators.at(hand).stiffness);
      o.print(testing::PrintToString(trial) + ", giant, " + what);
      EXPECT_EQ(o.fault, Fault::kNone) << what << ": " << traits(o.fault).name;
      EXPECT_LE(o.swing, 0.05e-3) << what;
      EXPECT_LE(o.port_energy, 1e-3) << what;
      EXPECT_GT(o.torque, 1e-3) << what << ": was not felt";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rods, RoomScaleTorsion, testing::Values(0.05, 0.1, 0.18));
INSTANTIATE_TEST_SUITE_P(Rods, Torsion,
                         testing::Values(TurnTrial{"proxy", 0.05}, TurnTrial{"proxy", 0.1},
                                         TurnTrial{"proxy", 0.18}, TurnTrial{"field", 0.05},
                                         TurnTrial{"field", 0.1}, TurnTrial{"field", 0.18}));

}  // namespace
}  // namespace palpate
