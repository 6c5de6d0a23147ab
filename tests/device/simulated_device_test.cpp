// The simulated device and hand against mechanics that can be solved by hand.
#include <palpate/device/simulated_device.h>

#include <cmath>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/device/profiles.h>
#include <support/tick.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;

Pose still(double) { return {}; }

DeviceCapabilities strong() {
  DeviceCapabilities c;
  c.force_max = 20.0;
  return c;
}

/// Reads at 1 kHz, with what the motors are told from the second reading on.
struct Bench {
  explicit Bench(const PlantProperties& plant, const HandProperties& hand, HandPath path = still,
                 const DeviceCapabilities& capabilities = strong())
      : device(capabilities, plant, hand, std::move(path)) {
    device.read(t, reading);
  }
  void run(double seconds, const Wrench& wrench = {}) {
    for (int k = 0; k < std::lround(seconds / kTick); ++k) {
      device.write(wrench);
      t += kTick;
      ASSERT_TRUE(device.read(t, reading));
    }
  }
  double t = 7.0;
  SimulatedDevice device;
  DeviceReading reading;
};

PlantProperties plant_of(double mass, double damping) {
  PlantProperties p;
  p.mass = mass;
  p.damping = damping;
  return p;
}

const Wrench kPush{{2.0, 0, 0}, Vector3d::Zero()};

TEST(SimulatedDevice, SwingsAsASpringAndAMassDo) {
  // m x'' + b x' + k x = F from rest, with all of m, b and k made of the device's and the hand's.
  Bench bench(plant_of(0.1, 0.5), {0.2, 1.0, 300.0});
  const double m = 0.3, b = 1.5, k = 300.0, decay = b / (2 * m), w = std::sqrt(k / m - decay * decay);
  for (double t = kTick; t < 0.5; t += kTick) {
    bench.run(kTick, kPush);
    const double exact =
        2.0 / k * (1.0 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
    EXPECT_NEAR(bench.device.pose().position.x(), exact, 0.01 * 2.0 / k) << t;
  }
}

TEST(SimulatedDevice, RestsWhereTheHandHoldsThePush) {
  Bench bench(plant_of(0.1, 0.5), {0.1, 5.0, 400.0});
  bench.run(3.0, kPush);
  EXPECT_NEAR(bench.device.pose().position.x(), 2.0 / 400.0, 1e-9);
  EXPECT_LT((bench.device.hand_force() + kPush.force).norm(), 1e-6);
}

TEST(SimulatedDevice, DryFrictionHoldsAndThenStops) {
  PlantProperties plant = plant_of(0.1, 0.5);
  plant.coulomb = 0.3;
  Bench bench(plant, {0.1, 5.0, 400.0});
  bench.run(1.0, {{0, 0.29, 0}, Vector3d::Zero()});
  EXPECT_EQ(bench.device.pose().position, Vector3d::Zero());
  bench.run(3.0, kPush);  // stops where friction holds what the spring leaves
  EXPECT_LE(std::abs(400.0 * bench.device.pose().position.x() - 2.0), 0.3);
  EXPECT_GT(bench.device.pose().position.x(), 0.004);
  EXPECT_EQ(bench.device.velocity().linear, Vector3d::Zero());
}

TEST(SimulatedDevice, MotorsAreLateByTheDelayAndNoStrongerThanTheyAre) {
  PlantProperties plant = plant_of(0.5, 0.0);
  plant.delay = 3e-3;
  DeviceCapabilities weak = strong();
  weak.force_max = 1.0;
  Bench bench(plant, {0.0, 0.0, 0.0}, still, weak);
  bench.run(2 * kTick, kPush);
  EXPECT_EQ(bench.device.pose().position, Vector3d::Zero());
  bench.run(5 * kTick, kPush);
  // From 3 ms on, 1 N on 0.5 kg; to a step of the integration.
  EXPECT_NEAR(bench.device.velocity().linear.x(), 1.0 / 0.5 * 4e-3, 2.0 * 2 * SimulatedDevice::kStep);
}

TEST(SimulatedDevice, ItsWatchdogTurnsItsMotorsOffOnceNothingIsWritten) {
  DeviceCapabilities watched = strong();
  watched.watchdog = 0.05;
  Bench bench(plant_of(0.1, 0.5), {0.1, 5.0, 400.0}, still, watched);
  bench.run(0.1, kPush);
  EXPECT_EQ(bench.device.motors().force, kPush.force);
  for (int k = 1; k <= 60; ++k) {
    bench.device.read(bench.t += kTick, bench.reading);
    if (k <= 48) {
      EXPECT_EQ(bench.device.motors().force, kPush.force) << k;
    }
  }
  EXPECT_EQ(bench.device.motors().force, Vector3d::Zero());
  bench.run(2 * kTick, kPush);
  EXPECT_EQ(bench.device.motors().force, kPush.force);
}

TEST(SimulatedDevice, FollowsTheHand) {
  const auto path = [](double t) {
    Pose p;
    p.position = {0.1 * (t - 7.0), 0, 0};
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(t - 7.0, Vector3d::UnitZ()));
    return p;
  };
  for (const double torque_max : {0.0, 0.3}) {
    DeviceCapabilities c = strong();
    c.torque_max = torque_max;
    Bench bench(plant_of(0.1, 0.0), {0.1, 5.0, 400.0}, path, c);
    bench.run(1.0);
    EXPECT_NEAR(bench.reading.pose.position.x(), 0.1, 1e-5);
    EXPECT_NEAR(bench.reading.velocity.linear.x(), 0.1, 1e-4);
    EXPECT_NEAR(bench.reading.velocity.angular.z(), 1.0, 1e-3);
    EXPECT_LT(bench.reading.pose.orientation.angularDistance(path(bench.t).orientation), 1e-4);
  }
}

TEST(SimulatedDevice, ATorqueTurnsWhatHasMotorsForIt) {
  DeviceCapabilities c = strong();
  c.torque_max = 0.5;
  PlantProperties plant = plant_of(0.1, 0.5);
  Bench bench(plant, {0.1, 5.0, 400.0}, still, c);
  bench.run(3.0, {Vector3d::Zero(), {0, 0.01, 0}});
  const Eigen::AngleAxisd turn(bench.device.pose().orientation);
  EXPECT_NEAR(turn.angle() * turn.axis().y(), 0.01 / (400.0 * plant.gyration * plant.gyration), 1e-6);
}

TEST(SimulatedDevice, TellsWhatItsEncodersTell) {
  PlantProperties plant = plant_of(0.1, 0.5);
  plant.resolution = 50e-6;
  Bench bench(plant, {0.1, 5.0, 400.0});
  for (int k = 0; k < 300; ++k) {
    bench.run(kTick, kPush);
    const Vector3d steps = bench.reading.pose.position / plant.resolution;
    EXPECT_NEAR(steps.x(), std::round(steps.x()), 1e-9);
    EXPECT_LE(std::abs(bench.reading.pose.position.x() - bench.device.pose().position.x()), 25.0001e-6);
  }
}

TEST(SimulatedDevice, HasNothingNewUntilTimePasses) {
  Bench bench(plant_of(0.1, 0.5), {});
  DeviceReading same = bench.reading;
  EXPECT_FALSE(bench.device.read(bench.t, same));
  EXPECT_TRUE(bench.device.read(bench.t + 1e-4, same));
}

// That the bound of theory (Colgate: K < 2 b / T) is other than the maker's stiffness shows that neither was
// made from the other.
TEST(DeviceProfiles, AreCreditedWithTheDampingOfTheirPlantAlone) {
  EXPECT_EQ(device_profiles().size(), 5U);
  for (const DeviceProfile& p : device_profiles()) {
    EXPECT_NO_THROW(check_capabilities(p.capabilities));
    EXPECT_EQ(p.capabilities.damping, p.plant.damping);
    const double about = p.capabilities.torque_max > 0.0 ? p.plant.gyration * p.plant.gyration : 0.0;
    EXPECT_EQ(p.capabilities.angular_damping, about * p.plant.damping);
    EXPECT_EQ(p.capabilities.damping_source, DampingSource::kSimulated);
    EXPECT_GE(p.plant.damping, 0.1);
    EXPECT_LE(p.plant.damping, 5.0);
    EXPECT_NE(2.0 * p.plant.damping * p.capabilities.rate, p.capabilities.stiffness_max);
    EXPECT_EQ(&device_profile(p.capabilities.name), &p);
  }
  EXPECT_THROW(device_profile("phantom"), Error);
}

}  // namespace
}  // namespace palpate
