// What a force sensor says, without what no hand can do.
#include <palpate/servo/force_sensor_guard.h>

#include <gtest/gtest.h>

#include <support/not_finite.h>
#include <support/tick.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kNan;
using test::kTick;

ForceSensorLimits limits() {
  ForceSensorLimits l;
  l.force_range = 100.0;
  l.torque_range = 10.0;
  l.force_rate = 1e4;   // 10 N a tick
  l.torque_rate = 500;  // 0.5 N m a tick
  l.hold_time = 5.5e-3;
  l.saturated_time = 9.5e-3;
  return l;
}

class ForceSensorGuardTest : public testing::Test {
 protected:
  /// A tick later.
  SensorFault take(const Vector3d& force, const Vector3d& torque = Vector3d::Zero()) {
    t_ += kTick;
    return guard_.take({force, torque}, t_, t_);
  }
  SensorFault take_none() {
    t_ += kTick;
    return guard_.take({Vector3d::Zero(), Vector3d::Zero()}, 0.0, t_);
  }

  ForceSensorGuard guard_{limits()};
  double t_ = 1.0;
};

TEST_F(ForceSensorGuardTest, TakesNothingForAForceBeforeOneIsGood) {
  EXPECT_EQ(take({kNan, 0, 0}), SensorFault::kNotFinite);
  EXPECT_EQ(take({0, 0, 0}, {0, kNan, 0}), SensorFault::kNotFinite);
  EXPECT_EQ(guard_.take({}, kNan, t_), SensorFault::kNotFinite);
  EXPECT_EQ(take({50, 0, 0}), SensorFault::kNone) << "the first may be any";
  EXPECT_EQ(guard_.wrench().force, Vector3d(50, 0, 0));
}

TEST_F(ForceSensorGuardTest, HoldsTheLastGoodOneForItsTime) {
  take({1, 2, 3}, {0.1, 0.2, 0.3});
  for (int k = 0; k < 5; ++k) EXPECT_EQ(take_none(), SensorFault::kNone) << k;
  EXPECT_EQ(guard_.wrench().force, Vector3d(1, 2, 3));
  EXPECT_EQ(guard_.wrench().torque, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(take_none(), SensorFault::kDropout);
  EXPECT_EQ(take({kNan, 0, 0}), SensorFault::kNotFinite);
  EXPECT_EQ(take({1, 2, 4}), SensorFault::kNone);
  EXPECT_EQ(guard_.wrench().force, Vector3d(1, 2, 4));
}

TEST_F(ForceSensorGuardTest, NoHandIsQuickerThanItsRate) {
  take({0, 0, 0});
  EXPECT_EQ(take({9.9, 0, 0}), SensorFault::kNone);
  EXPECT_EQ(guard_.wrench().force.x(), 9.9);
  EXPECT_EQ(take({20.1, 0, 0}), SensorFault::kNone) << "held";
  EXPECT_EQ(guard_.wrench().force.x(), 9.9);
  EXPECT_EQ(take({29.0, 0, 0}), SensorFault::kNone) << "of two ticks";
  EXPECT_EQ(guard_.wrench().force.x(), 29.0);
  EXPECT_EQ(take({29.0, 0, 0}, {0, 0, 0.6}), SensorFault::kNone);
  EXPECT_EQ(guard_.wrench().torque.z(), 0.0);
  EXPECT_EQ(take({29.0, 0, 0}, {0, 0, 0.6}), SensorFault::kNone);
  EXPECT_EQ(guard_.wrench().torque.z(), 0.6);
}

TEST_F(ForceSensorGuardTest, SpikesThatGoOnAreAFault) {
  take({0, 0, 0});
  SensorFault found = SensorFault::kNone;
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(found, SensorFault::kNone) << k;
    found = take({k % 2 == 0 ? 99.0 : -99.0, 0, 0});
  }
  EXPECT_EQ(found, SensorFault::kSpike);
  EXPECT_EQ(guard_.wrench().force.x(), 0.0);
}

// Stamps that run ahead would permit any leap.
TEST_F(ForceSensorGuardTest, AStampOfTheFutureIsNoLongerTime) {
  take({0, 0, 0});
  t_ += kTick;
  EXPECT_EQ(guard_.take({{50, 0, 0}, Vector3d::Zero()}, t_ + 1.0, t_), SensorFault::kNone);
  EXPECT_EQ(guard_.wrench().force.x(), 0.0) << "held";
}

TEST_F(ForceSensorGuardTest, TheEndOfItsRangeIsAFaultAfterAWhile) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0, 0, 1)})
    for (const bool turns : {false, true}) {
      guard_ = ForceSensorGuard(limits());
      const Vector3d force = turns ? Vector3d::Zero() : Vector3d(100.0 * axis);
      const Vector3d torque = turns ? Vector3d(10.0 * axis) : Vector3d::Zero();
      for (int k = 0; k < 10; ++k) EXPECT_EQ(take(force, torque), SensorFault::kNone) << k;  // 9 ms
      EXPECT_EQ(take(0.95 * force, 0.96 * torque), SensorFault::kNone)
          << "it counts from the beginning again";
      for (int k = 0; k < 9; ++k) EXPECT_EQ(take(force, torque), SensorFault::kNone) << k;
      EXPECT_EQ(take(force, torque), SensorFault::kSaturated);
    }
}

TEST_F(ForceSensorGuardTest, TheBiasIsTheMeanSinceTheTareBegan) {
  take({3, 2, 1}, {0.1, 0.1, 0.1});
  guard_.begin_tare();
  take({1, 0, -1}, {0.1, 0, 0});
  take({2, 0, -1}, {0, 0, 0.2});
  EXPECT_EQ(guard_.wrench().force, Vector3d(2, 0, -1));
  EXPECT_EQ(guard_.tare(), SensorFault::kNone);
  EXPECT_TRUE(guard_.bias().force.isApprox(Vector3d(1.5, 0, -1)));
  EXPECT_TRUE(guard_.bias().torque.isApprox(Vector3d(0.05, 0, 0.1)));
  EXPECT_TRUE(guard_.wrench().force.isApprox(Vector3d(0.5, 0, 0)));
  EXPECT_TRUE(guard_.wrench().torque.isApprox(Vector3d(-0.05, 0, 0.1)));
}

TEST_F(ForceSensorGuardTest, AHandIsNoBias) {
  take({1, 0, 0});
  ASSERT_EQ(guard_.tare(), SensorFault::kNone);
  guard_.begin_tare();
  take({4, 0, 0});
  EXPECT_EQ(guard_.tare(), SensorFault::kBias);
  guard_.begin_tare();
  take({0, 0, 0}, {0, 0.4, 0});
  EXPECT_EQ(guard_.tare(), SensorFault::kBias);
  EXPECT_EQ(guard_.bias().force, Vector3d(1, 0, 0)) << "as it was";
}

TEST_F(ForceSensorGuardTest, WithoutAMeasurementThereIsNoBias) {
  EXPECT_EQ(guard_.tare(), SensorFault::kDropout);
  take({1, 0, 0});
  ASSERT_EQ(guard_.tare(), SensorFault::kNone);
  guard_.begin_tare();
  EXPECT_EQ(guard_.tare(), SensorFault::kDropout);
  EXPECT_EQ(guard_.bias().force, Vector3d(1, 0, 0)) << "as it was";
}

}  // namespace
}  // namespace palpate
