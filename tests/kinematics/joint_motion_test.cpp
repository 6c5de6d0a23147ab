// Joint motion within limits, whatever is asked of it.
#include <palpate/kinematics/joint_motion.h>

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <palpate/geometry/rotation.h>
#include <palpate/kinematics/chain_file.h>
#include <support/heap_guard.h>
#include <support/random_joints.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 1e-3;
/// Of an acceleration, which is a difference of velocities over a tick.
constexpr double kRounding = 1e-9;

class JointMotionTest : public testing::Test {
 protected:
  /// One tick, after which every joint is within its limits and where its velocity has taken it.
  void step(const Pose& target, double dt = kTick) {
    const JointVector q = motion_.position(), dq = motion_.velocity();
    motion_.step(target, dt);
    check(q, dq, dt);
  }
  void check(const JointVector& q, const JointVector& dq, double dt) {
    const ChainLimits& l = motion_.limits();
    const JointVector &now = motion_.position(), &speed = motion_.velocity();
    ASSERT_TRUE(now.allFinite() && speed.allFinite());
    for (Eigen::Index i = 0; i < now.size(); ++i) {
      ASSERT_GE(now[i], l.lower[i]);
      ASSERT_LE(now[i], l.upper[i]);
      ASSERT_LE(std::abs(speed[i]), l.velocity[i] * (1 + kRounding));
      ASSERT_LE(std::abs(speed[i] - dq[i]), l.acceleration[i] * dt * (1 + kRounding) + 1e-12);
      ASSERT_NEAR(now[i], q[i] + speed[i] * dt, 1e-12);
    }
  }

  SerialChain chain_ = giant_chain();
  JointMotion motion_{chain_};
};

/// A person who walks about and reaches: slow over the room, quicker with the arm.
Pose walk(const Pose& middle, double t) {
  Pose pose = middle;
  const double u = std::min(1.0, t / 3.0), ease = u * u * (3.0 - 2.0 * u);
  pose.position +=
      ease * Vector3d(1.6 * std::sin(0.31 * t) + 0.15 * std::sin(2.1 * t),
                      1.9 * std::sin(0.23 * t) + 0.1 * std::sin(3.3 * t), 0.2 * std::sin(0.9 * t));
  pose.orientation = rotation_by(ease * Vector3d(0.4 * std::sin(0.7 * t), 0.3 * std::sin(1.1 * t),
                                                 0.8 * std::sin(0.4 * t))) *
                     pose.orientation;
  return pose;
}

TEST_F(JointMotionTest, FollowsAPersonWhoWalksForMinutes) {
  const Pose middle = motion_.tip();
  double worst = 0.0;
  for (int k = 0; k < 180'000; ++k) {
    const Pose target = walk(middle, kTick * k);
    step(target);
    worst = std::max(worst, motion_.lag().norm());
    ASSERT_EQ(motion_.held_by(), HeldBy::kNothing) << kTick * k;
  }
  EXPECT_LT(worst, 1e-4);
}

TEST_F(JointMotionTest, IsExactAtRest) {
  Pose target = motion_.tip();
  target.position += Vector3d(0.3, -0.2, 0.1);
  target.orientation = rotation_by({0.2, 0.1, -0.3}) * target.orientation;
  for (int k = 0; k < 5000; ++k) step(target);
  EXPECT_LT(motion_.lag().norm(), 1e-6);
}

TEST_F(JointMotionTest, NeverLeavesItsLimitsWhateverIsAsked) {
  std::mt19937_64 random(21);
  Pose target = motion_.tip();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k < 60'000; ++k) {
    if (random() % 50 == 0) {
      target.position = {test::uniform(random, -4, 4), test::uniform(random, -4, 4),
                         test::uniform(random, -1, 4)};
      target.orientation = rotation_by(
          Vector3d{test::uniform(random, -3, 3), test::uniform(random, -3, 3), test::uniform(random, -3, 3)});
      if (random() % 10 == 0) target.position.x() = nan;
    }
    step(target, random() % 20 == 0 ? 6e-3 : test::uniform(random, 0.2e-3, 2e-3));
    if (HasFatalFailure()) FAIL() << k;
  }
}

TEST_F(JointMotionTest, SaysWhatHoldsIt) {
  Pose target = motion_.tip();
  target.position.x() += 1.0;  // a jump: as fast as it may
  step(target);
  EXPECT_EQ(motion_.held_by(), HeldBy::kAcceleration);
  target.position.x() = 9.0;  // outside of the room
  for (int k = 0; k < 20'000; ++k) step(target);
  EXPECT_EQ(motion_.held_by(), HeldBy::kPosition);
  EXPECT_NEAR(motion_.position()[0], 2.35, 0.01);
  EXPECT_LT(motion_.velocity().norm(), 0.1);  // what the arm still does to lean out is slow, and even
  EXPECT_LT(motion_.acceleration().norm(), 1.0);
  target.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  step(target);
  EXPECT_EQ(motion_.held_by(), HeldBy::kNotFinite);
}

TEST_F(JointMotionTest, StretchesTowardsWhatIsOutOfReachAndComesBack) {
  const Pose home = motion_.tip();
  Pose target = home;
  target.position.z() = 0.2;  // the arm ends at 0.8 m, stretched: singular
  for (int k = 0; k < 6000; ++k) step(target);
  EXPECT_NE(motion_.held_by(), HeldBy::kNothing);
  EXPECT_LT(motion_.velocity().norm(), 0.1);
  EXPECT_LT(motion_.acceleration().norm(), 1.0);
  for (int k = 0; k < 6000; ++k) step(home);
  EXPECT_LT(motion_.lag().norm(), 1e-5);
}

TEST_F(JointMotionTest, BrakesWithinTheTimeOfTheSlowestJoint) {
  const ChainLimits& l = motion_.limits();
  Pose target = motion_.tip();
  target.position += Vector3d(1.5, 1.5, 0.2);
  for (int k = 0; k < 400; ++k) step(target);
  EXPECT_GT(motion_.velocity().norm(), 0.5);
  const double most = (l.velocity.array() / l.acceleration.array()).maxCoeff();
  for (double t = 0.0; t < most + kTick; t += kTick) {
    const JointVector q = motion_.position(), dq = motion_.velocity();
    motion_.brake(kTick);
    check(q, dq, kTick);
  }
  EXPECT_EQ(motion_.velocity().norm(), 0.0);
}

TEST_F(JointMotionTest, RedundancyGoesToTheRestOfTheJoints) {
  JointVector q = motion_.limits().rest;
  q[2] += 1.0;
  motion_.start(q);
  const Pose target = motion_.tip();
  const auto away = [&] {
    return ((motion_.position() - motion_.limits().rest).array() / motion_.limits().velocity.array())
        .matrix()
        .norm();
  };
  const double first = away();
  double before = first;
  for (int k = 0; k < 30'000; ++k) {
    step(target);
    ASSERT_LT(motion_.lag().norm(), 1e-5);
    ASSERT_LE(away(), before + 1e-9);
    before = away();
  }
  EXPECT_LT(before, 0.9 * first);
}

TEST_F(JointMotionTest, TakesNothingFromTheHeap) {
  const Pose middle = motion_.tip();
  Pose far = middle;
  far.position.x() = 9.0;
  const test::HeapGuard guard;
  for (int k = 0; k < 1000; ++k) motion_.step(k % 100 < 50 ? walk(middle, kTick * k) : far, kTick);
  for (int k = 0; k < 100; ++k) motion_.brake(kTick);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
