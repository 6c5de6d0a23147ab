// From forces to motion.
#include <palpate/servo/admittance_controller.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/tick.h>
#include <support/uniform.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;
using test::uniform;

MotionLimits wide() {
  MotionLimits limits;
  limits.velocity = limits.angular_velocity = 100.0;
  limits.acceleration = limits.angular_acceleration = 1e4;
  limits.jerk = limits.angular_jerk = 1e9;
  return limits;
}

// v = F / D (1 - exp(-D t / M)), and the same about an axis.
TEST(AdmittanceController, IsAMassWithADamper) {
  Admittance a;
  a.mass = {2.0, 3.0, 4.0};
  a.damping = {10.0, 0.0, 40.0};
  AdmittanceController controller(a, wide());
  controller.start({});
  const Wrench user{{3.0, 1.0, -2.0}, {0.05, 0, 0}}, scene{{1.0, 0.5, -2.0}, {0, 0, 0}};
  for (int k = 0; k < 1000; ++k) controller.step(user, scene, kTick);
  const Twist& v = controller.motion().velocity;
  EXPECT_NEAR(v.linear.x(), 0.4 * (1 - std::exp(-5.0)), 1e-3);
  EXPECT_NEAR(v.linear.y(), 0.5, 1e-3);
  EXPECT_NEAR(v.linear.z(), -0.1 * (1 - std::exp(-10.0)), 1e-3);
  EXPECT_NEAR(v.angular.x(),
              0.05 / a.angular_damping.x() * (1 - std::exp(-a.angular_damping.x() / a.inertia.x())), 1e-3);
}

// At the end of each step, M a = F - D v to rounding, whatever the mass and the length of the step.
TEST(AdmittanceController, KeepsItsEquationInEveryStep) {
  for (const double dt : {1e-3, 20e-3}) {
    Admittance a;
    a.mass = {0.5, 2.0, 20.0};
    a.damping = {80.0, 10.0, 1.0};
    a.inertia = {0.01, 0.02, 0.05};
    a.angular_damping = {0.5, 0.1, 0.0};
    AdmittanceController controller(a, wide());
    controller.start({});
    for (int k = 0; k < 50; ++k) {
      const Wrench user{{3.0 + 0.1 * k, -1.0, 2.0}, {0.05, -0.01 * k, 0.02}};
      const MotionSetpoint& m = controller.step(user, {}, dt);
      const Vector3d force = user.force - a.damping.cwiseProduct(m.velocity.linear);
      const Vector3d torque = user.torque - a.angular_damping.cwiseProduct(m.velocity.angular);
      EXPECT_LT((a.mass.cwiseProduct(m.acceleration.linear) - force).norm(), 1e-9) << k;
      EXPECT_LT((a.inertia.cwiseProduct(m.acceleration.angular) - torque).norm(), 1e-9) << k;
    }
  }
}

TEST(AdmittanceController, TurnsByItsAngularVelocity) {
  Admittance a;
  a.inertia.setConstant(0.02);
  a.angular_damping.setConstant(0.1);
  AdmittanceController controller(a, wide());
  controller.start({});
  double turned = 0.0, before = 0.0;
  for (int k = 0; k < 500; ++k) {
    const double w = controller.step({{}, {0, 0, 0.2}}, {}, kTick).velocity.angular.z();
    turned += 0.5 * kTick * (before + w);
    before = w;
  }
  ASSERT_GT(turned, 0.5);
  const Eigen::AngleAxisd turn(controller.motion().pose.orientation);
  EXPECT_NEAR(turn.angle(), turned, 1e-4);
  EXPECT_NEAR(turn.axis().z(), 1.0, 1e-9);
}

// v = F / (D + B) where the scene pushes, F / D along it and after it.
TEST(AdmittanceController, ContactDampsAlongTheScenesForceAlone) {
  Admittance a;
  a.mass.setConstant(1.5);
  a.damping.setConstant(10.0);
  a.contact_damping = 30.0;
  AdmittanceController controller(a, wide());
  controller.start({});
  const Wrench user{{2.0, 0.0, 2.0}, {0, 0, 0}}, scene{{0.0, -3.0, 4.0}, {0, 0, 0}};
  for (int k = 0; k < 5000; ++k) controller.step(user, scene, kTick);
  // Of (2, -3, 6) N, -3 * -0.6 + 6 * 0.8 = 6.6 N is along n = (0, -0.6, 0.8), and (2, 0.96, 0.72) N across
  // it.
  const Vector3d n(0.0, -0.6, 0.8), across(2.0, 0.96, 0.72);
  EXPECT_TRUE(controller.motion().velocity.linear.isApprox(6.6 / 40.0 * n + across / 10.0, 1e-3));
  for (int k = 0; k < 5000; ++k) controller.step(user, {}, kTick);
  EXPECT_TRUE(controller.motion().velocity.linear.isApprox(user.force / 10.0, 1e-3));
}

// On a spring, a damping ratio of 0.7 overshoots by exp(-pi 0.7 / sqrt(1 - 0.7^2)) = 4.6 %.
TEST(AdmittanceController, ContactDampingBringsAMassToRestOnASpring) {
  Admittance a;
  a.mass.setConstant(1.5);
  a.damping.setZero();
  a.contact_damping = 2.0 * 0.7 * std::sqrt(500.0 * 1.5);
  AdmittanceController controller(a, wide());
  DevicePose start;
  start.position.z() = -0.001;
  controller.start(start);
  double deepest = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const double z = controller.motion().pose.position.z();
    deepest = std::max(deepest, -z);
    // The hand pushes from the start, more once the damping is there.
    const double push = k < 1000 ? 0.5 : 1.0;
    controller.step({{0, 0, -push}, {0, 0, 0}}, {{0, 0, -500.0 * z}, {0, 0, 0}}, kTick);
  }
  EXPECT_NEAR(deepest, 0.002 + 0.046 * 0.001, 1e-5);
  EXPECT_NEAR(controller.motion().pose.position.z(), -0.002, 1e-6);
}

TEST(AdmittanceController, KeepsItsLimitsWhateverTheForces) {
  MotionLimits limits;
  limits.workspace = Eigen::AlignedBox3d(Vector3d(-0.3, -0.4, 0.9), Vector3d(0.3, 0.4, 1.6));
  Admittance a;
  a.contact_damping = 40.0;
  AdmittanceController controller(a, limits);
  DevicePose start;
  start.position.z() = 1.2;
  controller.start(start);
  std::mt19937_64 random(4);
  Wrench user, scene;
  for (int k = 0; k < 200'000; ++k) {
    if (random() % 200 == 0) {
      const double size = std::pow(10.0, uniform(random, -1, 4));
      for (Eigen::Index i = 0; i < 3; ++i) {
        user.force[i] = size * uniform(random, -1, 1);
        user.torque[i] = 0.1 * size * uniform(random, -1, 1);
      }
    }
    const double dt = uniform(random, 0.3e-3, 2e-3);
    const MotionSetpoint before = controller.motion();
    const MotionSetpoint& m = controller.step(user, scene, dt);
    ASSERT_TRUE(m.pose.position.allFinite());
    for (Eigen::Index i = 0; i < 3; ++i) {
      ASSERT_GE(m.pose.position[i], limits.workspace.min()[i] - 1e-9);
      ASSERT_LE(m.pose.position[i], limits.workspace.max()[i] + 1e-9);
      ASSERT_LE(std::abs(m.velocity.linear[i]), limits.velocity * (1 + 1e-9));
      ASSERT_LE(std::abs(m.velocity.angular[i]), limits.angular_velocity * (1 + 1e-9));
      ASSERT_LE(std::abs(m.acceleration.linear[i]), limits.acceleration * (1 + 1e-9));
      ASSERT_LE(std::abs(m.acceleration.linear[i] - before.acceleration.linear[i]),
                limits.jerk * dt * (1 + 1e-9));
      ASSERT_LE(std::abs(m.acceleration.angular[i] - before.acceleration.angular[i]),
                limits.angular_jerk * dt * (1 + 1e-9));
    }
    ASSERT_NEAR(m.pose.orientation.norm(), 1.0, 1e-12);
  }
}

TEST(AdmittanceController, BrakesInTheStatedTime) {
  AdmittanceController controller({}, {});
  controller.start({});
  for (int k = 0; k < 1000; ++k) controller.step({{400, -300, 50}, {5, 5, -5}}, {}, kTick);
  EXPECT_GT(controller.motion().velocity.linear.norm(), 1.5);
  const double time = controller.limits().stop_time();
  EXPECT_LT(time, 0.3);
  for (double t = 0.0; t < time; t += kTick) controller.brake(kTick);
  EXPECT_TRUE(controller.at_rest());
}

// Work that goes in is at least what the virtual mass holds: no change of parameters gives energy to a hand.
TEST(AdmittanceController, GivesNoEnergyWhileItsMassChanges) {
  AdmittanceController controller({}, wide());
  controller.start({});
  std::mt19937_64 random(9);
  double work = 0.0;
  for (int k = 0; k < 100'000; ++k) {
    if (random() % 300 == 0) {
      Admittance other;
      other.mass.setConstant(uniform(random, 0.5, 30.0));
      other.damping.setConstant(uniform(random, 5.0, 50.0));
      controller.set(other);
    }
    const Vector3d force(8.0 * std::sin(2e-3 * k), 5.0 * std::sin(5.3e-3 * k), 0.0);
    const Vector3d before = controller.motion().pose.position;
    controller.step({force, {}}, {}, kTick);
    work += force.dot(controller.motion().pose.position - before);
    const Vector3d& v = controller.motion().velocity.linear;
    const double held = 0.5 * v.cwiseProduct(controller.admittance().mass).dot(v);
    ASSERT_GE(work, held - 1e-3) << k;
  }
}

TEST(AdmittanceController, GoesOnFromWhereTheDeviceIs) {
  AdmittanceController controller({}, {});
  controller.start({});
  for (int k = 0; k < 300; ++k) controller.step({{30, 0, 0}, {}}, {}, kTick);
  MotionSetpoint held;
  held.pose = controller.motion().pose;
  held.pose.position.x() -= 0.01;
  controller.follow(held);
  EXPECT_EQ(controller.motion().velocity.linear.norm(), 0.0);
  const MotionSetpoint& m = controller.step({{30, 0, 0}, {}}, {}, kTick);
  EXPECT_NEAR(m.pose.position.x(), held.pose.position.x(), 1e-5);
}

TEST(AdmittanceController, TakesTheAccelerationOfTheDeviceWithinItsLimits) {
  MotionLimits limits;
  limits.acceleration = 10.0;
  limits.angular_acceleration = 20.0;
  AdmittanceController controller({}, limits);
  controller.start({});
  MotionSetpoint held;
  held.acceleration = {{1.0, -50.0, 0.0}, {0.0, 5.0, 500.0}};
  controller.follow(held);
  EXPECT_LT((controller.motion().acceleration.linear - Vector3d(1.0, -10.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((controller.motion().acceleration.angular - Vector3d(0.0, 5.0, 20.0)).norm(), 1e-12);
}

TEST(AdmittanceController, TakesNothingFromTheHeap) {
  AdmittanceController controller({}, {});
  controller.start({});
  const test::AllocationGuard guard;
  for (int k = 0; k < 1000; ++k) controller.step({{30, 1, 2}, {1, 2, 3}}, {}, kTick);
  for (int k = 0; k < 100; ++k) controller.brake(kTick);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
