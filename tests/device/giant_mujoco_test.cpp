// The room-scale device on its own plant and on MuJoCo.
#include <palpate/device/giant_mujoco.h>

#include <gtest/gtest.h>

#include <support/giant_trial.h>
#include <support/wall.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

std::unique_ptr<JointPlant> mujoco_plant(const JointPlantProperties& drives, const GripProperties& grip,
                                         HandPath path) {
  return std::make_unique<GiantMujoco>(test::giant(), drives, grip, std::move(path));
}

/// A hand that shakes a device whose drives hold still.
std::vector<Vector3d> shaken(JointPlant& plant, std::vector<Wrench>& felt) {
  const JointVector rest = ChainLimits(test::giant()).rest;
  plant.start(rest, 0.0);
  ChainKinematics at(test::giant());
  std::vector<Vector3d> way;
  for (int k = 1; k < 1000; ++k) {
    plant.advance(1e-3 * k, rest);
    at.set(plant.position());
    way.push_back(at.tip().position);
    felt.push_back(plant.hand());
  }
  return way;
}

// Open loop, with the command at rest: compliance, inertia and the force at the sensor.
TEST(GiantMujoco, SwingsAsTheOwnPlantDoes) {
  const Pose home = test::giant_home();
  const HandPath path = [home](double t) {
    Pose pose = home;
    const double on = std::min(1.0, 5.0 * t);
    pose.position +=
        on * Vector3d(0.05 * std::sin(9.0 * t), 0.04 * std::sin(14.0 * t), 0.03 * std::sin(20.0 * t));
    return pose;
  };
  JointPlantProperties drives;
  drives.coulomb = 0.0;
  drives.resonance = 60.0;  // soft, so that there is something to see
  const GripProperties grip{{0.3, 5.0, 1000.0}, 0.05};
  GiantPlant own(test::giant(), drives, grip, path);
  GiantMujoco other(test::giant(), drives, grip, path);
  std::vector<Wrench> own_felt, other_felt;
  const std::vector<Vector3d> a = shaken(own, own_felt), b = shaken(other, other_felt);
  double apart = 0.0, way = 0.0, force_apart = 0.0, force = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    apart = std::max(apart, (a[k] - b[k]).norm());
    way = std::max(way, (a[k] - home.position).norm());
    force_apart = std::max(force_apart, (own_felt[k].force - other_felt[k].force).norm());
    force = std::max(force, own_felt[k].force.norm());
  }
  EXPECT_GT(way, 1e-3);
  EXPECT_LT(apart, 0.02 * way);
  EXPECT_LT(force_apart, 0.02 * force);
}

struct Pressed {
  double stiffness;
  HandProperties hand;
};

class OnBothPlants : public testing::TestWithParam<std::size_t> {};

TEST_P(OnBothPlants, AWallFeelsAlike) {
  for (const double stiffness : {500.0, 2000.0}) {
    test::Wall wall(stiffness);
    test::GiantTrial trial;
    trial.hand = test::kOperators[GetParam()];
    trial.felt.model = &wall;
    trial.map.offset = Vector3d(0.01, 0, 0) - test::giant_home().position;
    trial.along.contact_stiffness = stiffness;
    trial.properties.sensor.noise = trial.properties.sensor.torque_noise = 0.0;
    trial.admittance.damping.setConstant(std::max(25.0, 1.2 * passive_damping(test::trial_loop(trial))));
    const test::GiantOutcome own = test::run_trial(trial);
    trial.plant = mujoco_plant;
    const test::GiantOutcome other = test::run_trial(trial);
    EXPECT_EQ(other.fault, Fault::kNone);
    EXPECT_EQ(other.motion_fault, Fault::kNone);
    EXPECT_NEAR(own.rest, other.rest, 0.05 * own.rest) << stiffness;
    EXPECT_NEAR(own.deepest, other.deepest, 0.05 * own.deepest) << stiffness;
    EXPECT_NEAR(own.scene_force, other.scene_force, 0.05 * own.scene_force) << stiffness;
    EXPECT_NEAR(own.true_force, other.true_force, 0.05 * own.true_force) << stiffness;
    EXPECT_NEAR(own.overshoot(), other.overshoot(), 0.05 * own.overshoot() + 0.02e-3) << stiffness;
    EXPECT_LE(other.limit_cycle, 0.05e-3) << stiffness;
    EXPECT_LE(other.port_energy, 1e-3) << stiffness;
    std::printf(
        "K %4.0f hand %4.0f | rest %.3f %.3f mm | overshoot %.3f %.3f mm | force %.3f %.3f N | cycle %.4f "
        "%.4f mm | energy %.4f %.4f mJ\n",
        stiffness, trial.hand.stiffness, 1e3 * own.rest, 1e3 * other.rest, 1e3 * own.overshoot(),
        1e3 * other.overshoot(), own.true_force, other.true_force, 1e3 * own.limit_cycle,
        1e3 * other.limit_cycle, 1e3 * own.port_energy, 1e3 * other.port_energy);
  }
}

INSTANTIATE_TEST_SUITE_P(Operators, OnBothPlants, testing::Range<std::size_t>(0, test::kOperators.size()));

}  // namespace
}  // namespace palpate
