#include <palpate/servo/passivity.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod = 1e-3;

/// A wall at z = 0 that is a spring.
struct SpringWall {
  double stiffness;
  double depth(const DevicePose& pose) const { return std::max(0.0, -pose.position.z()); }
  Wrench wrench(const DevicePose& pose) const { return {{0, 0, stiffness * depth(pose)}, Vector3d::Zero()}; }
  double stored(const DevicePose& pose) const { return 0.5 * stiffness * depth(pose) * depth(pose); }
};

DevicePose at(double z) {
  DevicePose pose;
  pose.position.z() = z;
  return pose;
}

TEST(PassiveStiffness, ByHand) {
  EXPECT_DOUBLE_EQ(passive_stiffness(1.0, 0.0, 1e-3, 0.0), 2000.0);   // 2 b / T
  EXPECT_DOUBLE_EQ(passive_stiffness(1.0, -0.5, 1e-3, 0.0), 1000.0);  // either sign of B costs
  EXPECT_DOUBLE_EQ(passive_stiffness(1.0, 0.0, 1e-3, 1e-3), 1.0 / 1.5e-3);
  EXPECT_EQ(passive_stiffness(1.0, 2.0, 1e-3, 0.0), 0.0);
}

// A torsional spring of 2 N m/rad, turned by 0.1 rad a tick, generates 2 * 0.1^2 / 2 J in each: 1e-3 N m
// s/rad absorb it, 0.1^2 / T of that.
TEST(PassivityController, CreditsTheDampingAboutAxes) {
  for (const double damping : {0.0, 0.4e-3, 1e-3}) {
    PassivityController controller(kPeriod, 0.0, 10.0, 0.05, damping);
    DevicePose pose;
    controller.correct({}, 0.0, {}, pose, kPeriod);
    pose.orientation = Eigen::AngleAxisd(0.1, Vector3d::UnitX());
    const Wrench wanted{Vector3d::Zero(), {-0.2, 0.0, 0.0}};
    controller.correct(wanted, 0.5 * 2.0 * 0.1 * 0.1, {}, pose, kPeriod);
    EXPECT_NEAR(controller.excess(), 0.5 * 2.0 * 0.1 * 0.1 - damping * 0.1 * 0.1 / kPeriod, 1e-12) << damping;
  }
}

TEST(PassivityController, AddsTheDampingThatASampledSpringLacks) {
  const SpringWall wall{1000.0};
  for (const double damping : {0.0, 0.2, 0.7}) {
    PassivityController controller(kPeriod, damping, 10.0);
    Wrench sent;
    for (int k = 0; k < 600; ++k) {  // at 0.1 m/s, 30 mm in and out again
      const DevicePose pose = at(-1e-4 * (k < 300 ? k : 600 - k));
      const Wrench wanted = wall.wrench(pose);
      sent = controller.correct(wanted, wall.stored(pose), sent, pose, kPeriod);
      // K T / 2 = 0.5 N s/m, less what the device has; twice that is added, once it moves evenly.
      const bool evenly = (k > 60 && k < 300) || (k > 400 && k < 550);
      if (evenly) {
        EXPECT_LE(controller.added_damping(), 2.0 * std::max(0.0, 0.5 - damping) + 1e-9) << k;
      }
    }
    EXPECT_EQ(controller.excess() > 0.0, damping < 0.5) << damping;
  }
}

TEST(PassivityController, LeavesAloneWhatIsPassive) {
  PassivityController controller(kPeriod, 1.0, 10.0);
  const SpringWall wall{1000.0};
  Wrench sent;
  for (int k = 0; k < 1000; ++k) {
    const DevicePose pose = at(-0.01 + 0.02 * std::cos(0.02 * k));
    const Wrench wanted = wall.wrench(pose);
    sent = controller.correct(wanted, wall.stored(pose), sent, pose, kPeriod);
    // Just out of the wall, whose edge was between two ticks, something is left to absorb.
    EXPECT_LT((sent.force - wanted.force).norm(), wall.depth(pose) > 0.0 ? 1e-9 : 0.05) << k;
  }
}

// A handle that is turned on the spot, against a torque of 0.02 N m that holds nothing: with an arm of 0.1 m,
// what that puts out is damped, and no more than once.
TEST(PassivityController, DampsTurnsByItsArm) {
  const Wrench twist{Vector3d::Zero(), {0.02, 0, 0}};
  constexpr double kStep = 1e-3;  // Unit: [rad].
  const auto sent_with = [&](double arm) {
    PassivityController controller(kPeriod, 0.0, 10.0, arm);
    DevicePose pose;
    controller.correct(twist, 0.0, twist, pose, kPeriod);
    pose.orientation = Eigen::AngleAxisd(kStep, Vector3d::UnitX());
    return controller.correct(twist, 0.0, twist, pose, kPeriod);
  };
  EXPECT_EQ(sent_with(0.0).torque, twist.torque);
  // Of 20 uJ out, alpha a^2 w^2 T = 20 uJ with w = 1 rad/s: 0.02 N m less.
  EXPECT_NEAR(sent_with(0.1).torque.x(), 0.0, 1e-9);
  EXPECT_EQ(sent_with(0.1).force, Vector3d::Zero());
  // At most 10 N s/m, with the square of 10 mm: 1e-3 N m at 1 rad/s.
  EXPECT_NEAR(sent_with(0.01).torque.x(), 0.019, 1e-9);
}

// Two of a tracker's poses that come together were not made so quickly: what the device absorbs is that of
// the time between them as promised.
TEST(PassivityController, ABunchOfReadingsIsNoSpeed) {
  const auto excess_after = [](double passed) {
    PassivityController controller(kPeriod, 0.3, 10.0);
    const Wrench push{{0, 0, 1}, Vector3d::Zero()};
    controller.correct(push, 1.0, push, at(0.0), kPeriod);
    controller.correct({}, 1.0, push, at(1e-4), passed);  // Z = 0.05 mJ, b d^2 / T = 0.003 mJ
    return controller.excess();
  };
  EXPECT_NEAR(excess_after(kPeriod), excess_after(1e-5), 1e-12);
  EXPECT_LT(excess_after(kPeriod), excess_after(3e-3));
}

// K T / 2 with the time that has really passed: 2 N s/m at 4 ms, where the device has 1.
TEST(PassivityController, TicksThatComeLaterLackMoreDamping) {
  const SpringWall wall{1000.0};
  for (const double period : {1e-3, 4e-3}) {
    PassivityController controller(kPeriod, 1.0, 10.0);
    Wrench sent;
    for (int k = 0; k < 100; ++k) {
      const DevicePose pose = at(-0.1 * period * k);
      sent = controller.correct(wall.wrench(pose), wall.stored(pose), sent, pose, period);
    }
    EXPECT_EQ(controller.excess() > 0.0, period > 2e-3) << period;
    EXPECT_LE(controller.added_damping(), 2.0 + 1e-9);
  }
}

/// A mass that is dropped on a wall, with next to no damping of its own. \returns the highest it comes back,
/// as a share of where it fell from, in three seconds.
double bounce(const SpringWall& wall, double damping_max) {
  PassivityController controller(kPeriod, 0.05, damping_max);
  constexpr double kMass = 0.1, kPush = 1.0, kDamping = 0.05, kStart = 0.01;
  constexpr int kSubsteps = 20;
  double z = kStart, v = 0.0, highest = 0.0;
  Wrench sent;
  bool touched = false;
  for (int k = 0; k < 3000; ++k) {
    const DevicePose pose = at(z);
    touched = touched || z < 0.0;
    if (touched) highest = std::max(highest, z);
    sent = controller.correct(wall.wrench(pose), wall.stored(pose), sent, pose, kPeriod);
    for (int s = 0; s < kSubsteps; ++s) {
      v += (sent.force.z() - kPush - kDamping * v) / kMass * kPeriod / kSubsteps;
      z += v * kPeriod / kSubsteps;
    }
  }
  return highest / kStart;
}

TEST(PassivityController, KeepsAStiffWallFromThrowing) {
  const SpringWall wall{4000.0};  // K T / 2 = 2 N s/m, forty times what there is
  EXPECT_GT(bounce(wall, 0.0), 2.0);
  EXPECT_LT(bounce(wall, 10.0), 1.0);
}

TEST(PassivityController, ResetForgets) {
  PassivityController controller(kPeriod, 0.0, 10.0);
  const Wrench push{{0, 0, 5}, Vector3d::Zero()};
  for (int k = 0; k < 10; ++k) controller.correct(push, 0.0, push, at(0.001 * k), kPeriod);
  EXPECT_NEAR(controller.port_energy(), 5 * 0.009, 1e-12);
  EXPECT_GT(controller.excess(), 0.0);
  controller.reset();
  EXPECT_EQ(controller.excess(), 0.0);
  EXPECT_EQ(controller.correct(push, 0.0, push, at(1.0), kPeriod).force, push.force);
  EXPECT_NEAR(controller.port_energy(), 5 * 0.009, 1e-12);  // what is done is done
}

/// Moves from z = 0 to z and back, in steps of 0.1 mm, against a spring.
void press_and_let_go(PassivityController& controller, const SpringWall& wall, double z, Wrench& sent) {
  const int steps = static_cast<int>(std::lround(std::abs(z) / 1e-4));
  for (int k = 0; k <= 2 * steps; ++k) {
    const DevicePose pose = at(-1e-4 * (k <= steps ? k : 2 * steps - k));
    controller.correct(wall.wrench(pose), wall.stored(pose), sent, pose, kPeriod);
    sent = wall.wrench(pose);
  }
}

// Held from step to step, the spring pushes back less on the way in and more on the way out: by K d^2 / 2 in
// each of 100 steps there and back.
TEST(PassivityController, ASampledSpringPutsOutMoreThanItTakes) {
  PassivityController controller(kPeriod, 0.0, 0.0);
  Wrench sent;
  press_and_let_go(controller, {1000.0}, -0.01, sent);
  EXPECT_NEAR(controller.port_energy(), 200 * 0.5 * 1000.0 * 1e-4 * 1e-4, 1e-9);
}

TEST(PassivityController, WhatTheDeviceAbsorbsDoesNotReachTheHand) {
  PassivityController controller(kPeriod, 0.3, 0.0);  // K T / 2 = 0.5 N s/m
  Wrench sent;
  press_and_let_go(controller, {1000.0}, -0.01, sent);
  EXPECT_NEAR(controller.port_energy(), (0.5 - 0.3) / 0.5 * 200 * 0.5 * 1000.0 * 1e-4 * 1e-4, 1e-9);
}

// What winds up by itself has made nothing until it comes out.
TEST(PassivityController, WhatWindsUpByItselfCountsWhenItComesOut) {
  PassivityController controller(kPeriod, 0.0, 0.0);
  const auto force = [](double f) { return Wrench{{0, 0, f}, Vector3d::Zero()}; };
  controller.correct(force(0), 0.0, force(0), at(0.0), kPeriod);
  for (int k = 0; k < 10; ++k) controller.correct(force(k), 0.01 * k, force(k), at(0.0), kPeriod);
  EXPECT_EQ(controller.port_energy(), 0.0);
  controller.correct(force(10), 0.0, force(10), at(0.005), kPeriod);
  EXPECT_NEAR(controller.port_energy(), 10 * 0.005, 1e-12);
}

// Of what was put in, a spring that gives way keeps no more than it holds.
TEST(PassivityController, WhatTheSpringHasLostDoesNotComeBack) {
  PassivityController controller(kPeriod, 0.0, 0.0);
  const Wrench push{{0, 0, 4}, Vector3d::Zero()};
  controller.correct(push, 0.0, push, at(0.0), kPeriod);
  controller.correct(push, 1.0, push, at(-0.010), kPeriod);    // 40 mJ in
  controller.correct(push, 0.008, push, at(-0.010), kPeriod);  // 8 are left
  controller.correct(push, 0.0, push, at(-0.005), kPeriod);    // 20 come out
  EXPECT_NEAR(controller.port_energy(), 0.012, 1e-12);
}

TEST(PassivityController, OnlyObservesWhatHasNoPotential) {
  PassivityController controller(kPeriod, 0.0, 100.0);
  const double unknown = std::numeric_limits<double>::infinity();
  const Wrench push{{0, 0, 4}, Vector3d::Zero()};
  for (int k = 0; k < 10; ++k)
    EXPECT_EQ(controller.correct(push, unknown, push, at(0.001 * k), kPeriod).force, push.force);
  EXPECT_NEAR(controller.port_energy(), 4 * 0.009, 1e-12);
  EXPECT_EQ(controller.added_damping(), 0.0);
}

TEST(PassivityController, AddsNothingToAHandleThatStandsStill) {
  PassivityController controller(kPeriod, 0.0, 20.0);
  const Wrench push{{0, 0, 5}, Vector3d::Zero()};
  controller.correct(push, 1.0, push, at(0.0), kPeriod);
  controller.correct({}, 1.0, push, at(1e-4), kPeriod);
  EXPECT_GT(controller.added_damping(), 0.0);
  controller.correct({}, 1.0, {}, at(1e-4), kPeriod);
  EXPECT_EQ(controller.added_damping(), 0.0);
}

}  // namespace
}  // namespace palpate
