// Contacts through a device of the admittance type, and the bounds that are told before.
#include <cmath>
#include <cstdio>
#include <memory>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/haptics/density_force.h>
#include <palpate/haptics/proxy_force.h>
#include <support/giant_trial.h>
#include <support/noisy_plane.h>
#include <support/wall.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kMeet = 0.01;  ///< from where the hand waits to what it meets. Unit: [m].

/// What a person would set: at least the default, and what is passive with any hand.
Admittance comfortable(const test::GiantTrial& trial) {
  Admittance a;
  a.damping.setConstant(std::max(25.0, 1.2 * passive_damping(test::trial_loop(trial))));
  return a;
}

void expect_rest(const test::GiantOutcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.fault, Fault::kNone) << what << traits(outcome.fault).name;
  EXPECT_EQ(outcome.motion_fault, Fault::kNone) << what << traits(outcome.motion_fault).name;
  EXPECT_LE(outcome.limit_cycle, 0.05e-3) << what;
  EXPECT_LE(outcome.port_energy, 1e-3) << what;
  EXPECT_GT(outcome.scene_force, 0.5) << what;
  EXPECT_NEAR(outcome.user_force, outcome.scene_force, 0.05 * outcome.scene_force) << what;
  EXPECT_NEAR(outcome.true_force, outcome.scene_force, 0.05 * outcome.scene_force) << what;
}

class Operator : public testing::TestWithParam<std::size_t> {};

TEST_P(Operator, RestsOnAWall) {
  for (const double stiffness : {200.0, 1000.0, 5000.0}) {
    test::Wall wall(stiffness);
    test::GiantTrial trial;
    trial.hand = test::kOperators[GetParam()];
    trial.felt.model = &wall;
    trial.map.offset = Vector3d(kMeet, 0, 0) - test::giant_home().position;
    trial.along.contact_stiffness = stiffness;
    trial.admittance = comfortable(trial);
    trial.margin = 1.2;
    const test::GiantOutcome outcome = test::run_trial(trial);
    expect_rest(outcome, "K " + std::to_string(stiffness));
    // Two springs in series: what the hand reaches beyond the wall is shared by their compliances.
    const double pushed = trial.depth - kMeet, k = trial.hand.stiffness;
    EXPECT_NEAR(outcome.true_force, pushed * k * stiffness / (k + stiffness), 0.02 * outcome.true_force);
    EXPECT_LT(outcome.overshoot(), 0.25 * (outcome.rest)) << stiffness;
    EXPECT_LT(outcome.wander, 0.3e-3);
    std::printf(
        "wall %4.0f N/m, hand %4.0f N/m: D %5.1f, overshoot %.2f mm, cycle %.4f mm, force %.3f N (user "
        "%.3f), energy %.4f mJ\n",
        stiffness, k, trial.admittance.damping.x(), 1e3 * outcome.overshoot(), 1e3 * outcome.limit_cycle,
        outcome.scene_force, outcome.user_force, 1e3 * outcome.port_energy);
  }
}

TEST_P(Operator, RestsOnAGaussianScene) {
  const Tool ball{Vector3d::Constant(0.02)};
  for (const bool proxy : {false, true}) {
    std::unique_ptr<ForceModel> model;
    if (proxy)
      model = std::make_unique<ProxyForce>(test::noisy_plane(), ball);
    else
      model = std::make_unique<DensityForce>(ball, DensityParameters{});
    ToolTracker contacts(test::noisy_plane(), ball);
    test::GiantTrial trial;
    trial.hand = test::kOperators[GetParam()];
    trial.felt = {model.get(), &contacts};
    trial.inward = -Vector3d::UnitZ();
    trial.map.offset = Vector3d(0, 0, 0.02 + kMeet) - test::giant_home().position;
    trial.depth = 0.02;
    trial.along.contact_stiffness = 1000.0;
    trial.admittance = comfortable(trial);
    trial.admittance.damping.setConstant(40.0);
    const test::GiantOutcome noisy = test::run_trial(trial);
    EXPECT_LE(noisy.limit_cycle, 0.1e-3);  // what the sensor's noise makes of a soft hand
    EXPECT_LE(noisy.port_energy, 1e-3);
    trial.properties.sensor.noise = trial.properties.sensor.torque_noise = 0.0;
    model->reset();
    const test::GiantOutcome outcome = test::run_trial(trial);
    std::printf(
        "%s, hand %4.0f N/m: overshoot %.2f mm, cycle %.4f mm, with noise %.4f, force %.3f N (user %.3f), "
        "energy "
        "%.4f mJ, %s\n",
        proxy ? "proxy" : "density", trial.hand.stiffness, 1e3 * outcome.overshoot(),
        1e3 * outcome.limit_cycle, 1e3 * noisy.limit_cycle, outcome.scene_force, outcome.user_force,
        1e3 * outcome.port_energy, traits(outcome.fault).name.data());
    expect_rest(outcome, proxy ? "proxy " : "density ");
  }
}

INSTANTIATE_TEST_SUITE_P(SoftToStiff, Operator, testing::Range<std::size_t>(0, test::kOperators.size()));

/// A hand that goes below the reach of the device, where its arm is straight, moves about there, and comes
/// back.
Pose below_the_reach(double t) {
  Pose pose = test::giant_home();
  const double down = std::clamp(t - 1.5, 0.0, 1.0), up = std::clamp(t - 4.0, 0.0, 1.0);
  pose.position.z() += -(pose.position.z() - 0.8) * down + 0.4 * up;
  pose.position.x() += 0.12 * down * (1.0 - up) * std::sin(5.0 * t);
  pose.position.y() += 0.1 * down * (1.0 - up) * std::sin(7.3 * t);
  return pose;
}

TEST(GiantReach, IsLeftAsFreelyAsItIsEntered) {
  test::Wall nothing(0.0);
  test::GiantTrial trial;
  trial.felt.model = &nothing;
  trial.map.offset = Vector3d(-10.0, 0.0, 0.0);  // far in front of the wall
  trial.along.contact_stiffness = 500.0;
  trial.admittance = comfortable(trial);
  GiantDevice device(test::giant(),
                     test::own_plant(trial.properties.drives, {trial.hand, 0.05}, below_the_reach),
                     trial.properties, test::giant_home());
  AdmittanceLoop loop(device, test::trial_options(trial));
  ServoTick tick(loop, trial.felt, {});
  double pulled = 0.0, lag = 0.0, held = 0.0;
  for (int k = 0; k < 6000; ++k) {
    const TickRecord& now = tick.run(1e-3 * k);
    ASSERT_EQ(now.fault, Fault::kNone) << traits(now.fault).name << " at " << now.t;
    ASSERT_NE(loop.status(), DeviceStatus::kFault) << loop.status_text() << " at " << now.t;
    held += *loop.held_by() != '\0' ? 1e-3 : 0.0;
    if (k > 4000) pulled = std::max(pulled, loop.user().force.norm());
    if (k > 5500) lag = std::max(lag, (device.pose().position - below_the_reach(now.t).position).norm());
  }
  std::printf("held for %.2f s, up with %.1f N, %.1f mm behind at the end\n", held, pulled, 1e3 * lag);
  EXPECT_GT(held, 0.5) << "it was not out of reach";
  EXPECT_LT(pulled, 50.0);
  EXPECT_LT(lag, 0.03);
}

/// A spring that holds from both sides, so that the loop is linear.
struct Spring final : ForceModel {
  explicit Spring(double stiffness) : k(stiffness) {}
  bool wants_contacts() const override { return false; }
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    ForceOutput out;
    out.wrench.force.x() = -k * input.tool.position.x();
    out.proxy = input.tool;
    out.stored_energy = 0.5 * k * input.tool.position.x() * input.tool.position.x();
    out.stiffness = k;
    return out;
  }
  double k;
};

/// With M = 1.5 kg and no friction: does a swing that a hand's movement leaves get larger?
bool holds(const test::GiantTrial& base, double damping) {
  test::GiantTrial trial = base;
  trial.admittance.damping.setConstant(damping);
  Spring spring(trial.along.contact_stiffness);
  trial.felt.model = &spring;
  trial.map.offset = -test::giant_home().position;
  trial.keeps_passive = false;
  trial.depth = 2e-3;
  const test::GiantOutcome outcome = test::run_trial(trial);
  return outcome.fault == Fault::kNone && outcome.late < outcome.early;
}

// What is told from M, D, K and delays, and what the device does.
TEST(GiantStability, IsWhatWasPredicted) {
  for (const double stiffness : {200.0, 1000.0, 5000.0})
    for (const double delay : {0.0, 2e-3, 5e-3, 10e-3}) {
      test::GiantTrial trial;
      trial.hand = test::kOperators[0];
      trial.along.contact_stiffness = stiffness;
      trial.properties.delay = delay;
      trial.properties.sensor.noise = trial.properties.sensor.torque_noise = 0.0;
      trial.properties.drives.coulomb = trial.properties.drives.viscous = 0.0;
      trial.properties.resolution = 0.0;
      AdmittanceLoopModel loop = test::trial_loop(trial);
      loop.delay += 0.5e-3;
      const double predicted = least_damping(1.5, loop, 1.0);
      double low = 0.5 * predicted, high = 2.0 * predicted + 0.5;
      for (int k = 0; k < 7; ++k) {
        const double middle = 0.5 * (low + high);
        (holds(trial, middle) ? high : low) = middle;
      }
      std::printf("K %4.0f N/m, delay %2.0f ms: least D predicted %6.2f, measured %6.2f N s/m (%.3f)\n",
                  stiffness, 1e3 * delay, predicted, high, high / predicted);
      // The device has as many modes as joints, and the prediction one: kDesignMargin is more than that.
      EXPECT_NEAR(high, predicted, 0.2 * predicted + 0.3) << stiffness << ", " << delay;
      if (predicted < 0.1) continue;
      // Half of that is refused, with the bound in the message.
      trial.admittance.damping.setConstant(0.5 * predicted);
      trial.margin = 1.0;
      EXPECT_THROW(test::run_trial(trial), Error);
    }
}

}  // namespace
}  // namespace palpate
