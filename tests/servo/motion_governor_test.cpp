// What stands between an admittance controller and a device.
#include <palpate/servo/motion_governor.h>

#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/not_finite.h>
#include <support/tick.h>

namespace palpate {
namespace {

using test::kNan;
using test::kTick;

MotionSafety safety() {
  MotionSafety s;
  s.sensor.force_range = 100.0;
  s.sensor.torque_range = 10.0;
  return s;
}

/// Of a handle that rests where nobody pushes.
MotionReading resting(double t) {
  MotionReading reading;
  reading.t = reading.user_t = t;
  return reading;
}

class MotionGovernorTest : public testing::Test {
 protected:
  /// One tick of a device that is where its controller is.
  void tick() {
    t_ += kTick;
    if (!frozen_) reading_.t = t_;
    if (!dropped_) reading_.user_t = t_;
    reading_.pose = controller_.motion().pose;
    reading_.velocity = controller_.motion().velocity;
    MotionReading said = reading_;
    if (spoil_) spoil_(said);
    governor_.admit(said, t_);
    const MotionSetpoint before = controller_.motion();
    if (governor_.brakes()) {
      controller_.brake(kTick);
    } else {
      const double share = governor_.share();
      controller_.step({share * governor_.user().force, share * governor_.user().torque}, {}, kTick);
    }
    if (!governor_.moved(controller_.motion(), before, controller_.at_rest())) controller_.start(before.pose);
    ASSERT_TRUE(controller_.motion().pose.position.allFinite());
  }
  void run(double time) {
    const int ticks = static_cast<int>(std::lround(time / kTick));
    for (int k = 0; k < ticks; ++k) tick();
  }
  void start() {
    controller_.start({});
    run(1.0);
    ASSERT_EQ(governor_.state(), GovernorState::kActive);
  }

  AdmittanceController controller_{{}, {}};
  MotionGovernor governor_{safety()};
  MotionReading reading_;
  std::function<void(MotionReading&)> spoil_;
  bool frozen_ = false, dropped_ = false;
  double t_ = 0.0;
};

TEST_F(MotionGovernorTest, OpensOnceNobodyPushesAndTakesWhatIsLeftForBias) {
  controller_.start({});
  reading_.user.force = {0.0, 8.0, 0.0};
  run(1.0);
  EXPECT_EQ(governor_.state(), GovernorState::kWaiting);
  EXPECT_TRUE(controller_.at_rest());
  reading_.user.force = {1.0, -0.5, 0.2};
  run(1.0);
  EXPECT_EQ(governor_.state(), GovernorState::kActive);
  EXPECT_TRUE(governor_.user().force.isZero(1e-12));
  EXPECT_TRUE(governor_.bias().force.isApprox(reading_.user.force, 1e-12));
  EXPECT_LT(controller_.motion().pose.position.norm(), 1e-3);
  reading_.user.force.x() += 5.0;
  run(1.0);
  EXPECT_NEAR(controller_.motion().velocity.linear.x(), 5.0 / 25.0, 0.01);
}

struct Wrong {
  const char* name;
  Fault fault;
  std::function<void(MotionReading&)> spoil;
};

TEST_F(MotionGovernorTest, EveryFaultBringsTheHandleToRestInTimeAndComesBackThroughTheGate) {
  const std::vector<Wrong> all{
      {"pose", Fault::kBadPose, [](MotionReading& r) { r.pose.position.x() = kNan; }},
      {"quaternion", Fault::kBadPose, [](MotionReading& r) { r.pose.orientation.coeffs() *= 2.0; }},
      {"velocity", Fault::kBadPose, [](MotionReading& r) { r.velocity.angular.y() = kNan; }},
      {"jump", Fault::kJump,
       [](MotionReading& r) { r.pose.position.x() += (std::lround(1e3 * r.t) % 2) != 0 ? 0.5 : 0.0; }},
      {"speed", Fault::kOverSpeed, [](MotionReading& r) { r.velocity.linear.x() = 30.0; }},
      {"hand", Fault::kChanging,
       [](MotionReading& r) { r.hand = static_cast<std::uint32_t>(std::lround(1e3 * r.t)); }},
      {"force", Fault::kForceSensor, [](MotionReading& r) { r.user.force.z() = kNan; }},
      {"torque", Fault::kForceSensor, [](MotionReading& r) { r.user.torque.z() = test::kInfinity; }},
      {"spikes", Fault::kForceSensor,
       [](MotionReading& r) { r.user.force.x() += (std::lround(1e3 * r.t) % 2) != 0 ? 2e5 : -2e5; }},
      {"dropout", Fault::kForceSensor, [](MotionReading& r) { r.user_t = 0.5; }},
      {"saturation", Fault::kForceSensor, [](MotionReading& r) { r.user.force.y() = 100.0; }},
      {"stale", Fault::kStalePose, [](MotionReading& r) { r.t = 0.5; }},
      {"not following", Fault::kNotFollowing,
       [behind = 0.0](MotionReading& r) mutable {
         r.pose.position.x() -= behind = std::min(0.2, behind + 1e-3);
       }},
  };
  start();
  for (const Wrong& wrong : all) {
    reading_.user.force = {12.0, 0.0, 0.0};
    run(0.6);
    ASSERT_EQ(governor_.state(), GovernorState::kActive) << wrong.name;
    ASSERT_GT(controller_.motion().velocity.linear.x(), 0.3) << wrong.name;
    spoil_ = wrong.spoil;
    double until = 1.0;
    while (governor_.fault() == Fault::kNone && until > 0.0) {
      tick();
      until -= kTick;
    }
    EXPECT_EQ(governor_.fault(), wrong.fault) << wrong.name << ": " << traits(governor_.fault()).name;
    run(controller_.limits().stop_time() + kTick);
    EXPECT_TRUE(controller_.at_rest()) << wrong.name;
    EXPECT_EQ(governor_.state(), GovernorState::kStopped) << wrong.name;
    spoil_ = nullptr;
    const Eigen::Vector3d rested = controller_.motion().pose.position;
    run(1.0);  // it still pushes: the gate stays shut
    EXPECT_EQ(controller_.motion().pose.position, rested) << wrong.name;
    if (traits(wrong.fault).latched) {
      EXPECT_EQ(governor_.state(), GovernorState::kStopped) << wrong.name;
      governor_.resume();
    }
    reading_.user.force.setZero();
    run(1.5);
    EXPECT_EQ(governor_.state(), GovernorState::kActive) << wrong.name;
  }
}

TEST_F(MotionGovernorTest, HoldsThroughSpikesAndGapsThatAreShort) {
  start();
  reading_.user.force = {5.0, 0.0, 0.0};
  spoil_ = [](MotionReading& r) {
    const long k = std::lround(1e3 * r.t);
    if (k % 20 == 0) r.user.force.x() = 90.0;
    if (k % 20 == 7) r.user.force.y() = kNan;
    if (k % 20 >= 12 && k % 20 < 15) r.user_t = 0.0;
  };
  run(2.0);
  EXPECT_EQ(governor_.state(), GovernorState::kActive) << to_string(governor_.sensor_fault());
  EXPECT_NEAR(controller_.motion().velocity.linear.x(), 5.0 / 25.0, 0.01);
}

TEST_F(MotionGovernorTest, TheForceGrowsEvenlyFromTheGate) {
  controller_.start({});
  while (governor_.state() == GovernorState::kWaiting) tick();
  EXPECT_EQ(governor_.share(), 0.0);
  run(0.25 * safety().rise_time);
  EXPECT_NEAR(governor_.share(), 0.25, 1e-9);
  run(0.5 * safety().rise_time);
  EXPECT_NEAR(governor_.share(), 0.75, 1e-9);
}

// In ticks that a double has exactly.
TEST(MotionGovernor, OpensAndComesBackAtItsTimesToTheTick) {
  constexpr double kExact = 1.0 / 1024.0;
  MotionSafety s = safety();
  s.tick = s.reading_period = kExact;
  MotionGovernor governor(s);
  const double end = 1.0;
  for (double t = 0.0; t <= 2.0 * end; t += kExact) {
    if (t == end) governor.stop(Fault::kChanging);
    governor.admit(resting(t), t);
    governor.moved({}, {}, true);
  }
  const double waits = end + s.recover_after;
  const std::vector<std::pair<double, GovernorState>> expected{
      {s.gate_time, GovernorState::kRising},
      {s.gate_time + s.rise_time, GovernorState::kActive},
      {end, GovernorState::kFalling},
      {end, GovernorState::kStopped},
      {waits, GovernorState::kWaiting},
      {waits + s.gate_time, GovernorState::kRising},
      {waits + s.gate_time + s.rise_time, GovernorState::kActive}};
  ASSERT_EQ(governor.transitions().size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(governor.transitions()[k].t, expected[k].first) << k;
    EXPECT_EQ(governor.transitions()[k].to, expected[k].second) << k;
  }
}

TEST(MotionGovernor, RemembersTheLastChangesOfState) {
  MotionGovernor governor(safety());
  std::vector<double> stopped;
  for (double t = kTick; stopped.size() < SafetyGovernor::kRemembered; t += kTick) {
    if (governor.state() == GovernorState::kWaiting) {
      governor.stop(Fault::kChanging);
      stopped.push_back(t);
    }
    governor.admit(resting(t), t);
    governor.moved({}, {}, true);
  }
  ASSERT_EQ(governor.transitions().size(), SafetyGovernor::kRemembered);
  std::vector<double> told;
  for (const GovernorTransition& change : governor.transitions())
    if (change.to == GovernorState::kFalling) told.push_back(change.t);
  ASSERT_GT(told.size(), 2U);
  EXPECT_EQ(told,
            std::vector<double>(stopped.end() - static_cast<std::ptrdiff_t>(told.size()), stopped.end()));
}

TEST(MotionGovernor, StaysShutBeforeTheDeviceAndItsSensorHaveSpoken) {
  MotionGovernor silent(safety()), deaf(safety());
  for (double t = 0.0; t < 1.0; t += kTick) {
    silent.admit_none(t);
    MotionReading reading = resting(t);
    reading.user.force.x() = kNan;
    deaf.admit(reading, t);
    for (MotionGovernor* governor : {&silent, &deaf}) {
      governor->moved({}, {}, true);
      ASSERT_TRUE(governor->brakes());
      ASSERT_EQ(governor->share(), 0.0);
    }
  }
  EXPECT_EQ(silent.fault(), Fault::kStalePose);
  EXPECT_EQ(deaf.fault(), Fault::kForceSensor);
}

TEST_F(MotionGovernorTest, TellsTheFirstFaultUnlessALaterOneIsForGood) {
  start();
  reading_.user.force = {12.0, 0.0, 0.0};
  run(0.5);
  governor_.stop(Fault::kChanging);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kChanging);
  governor_.stop(Fault::kStalled);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kChanging);
  governor_.stop(Fault::kPaused);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kPaused);
  governor_.stop(Fault::kNotFollowing);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kPaused);
  governor_.stop(Fault::kEmergencyStop);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kEmergencyStop);
  governor_.stop(Fault::kNotFollowing);
  tick();
  EXPECT_EQ(governor_.fault(), Fault::kEmergencyStop);
}

TEST_F(MotionGovernorTest, ResumesNothingThatIsAskedForInTheSameTick) {
  start();
  governor_.stop(Fault::kNotFollowing);
  tick();
  governor_.stop();
  governor_.resume();
  run(1.0);
  EXPECT_EQ(governor_.state(), GovernorState::kStopped);
  governor_.resume();
  governor_.stop(Fault::kPaused);
  governor_.unpause();
  run(1.0);
  EXPECT_EQ(governor_.state(), GovernorState::kStopped) << "it was paused in that tick";
  governor_.unpause();
  run(0.1);
  EXPECT_EQ(governor_.state(), GovernorState::kWaiting);
}

// A device whose clock runs ahead would never be stale.
TEST_F(MotionGovernorTest, AReadingOfTheFutureIsNone) {
  start();
  spoil_ = [](MotionReading& r) { r.t += 1.0; };
  run(safety().stale_after + 2 * kTick);
  EXPECT_EQ(governor_.fault(), Fault::kStalePose);
  EXPECT_LT(governor_.reading().t, t_);
}

TEST_F(MotionGovernorTest, LateTicksAreAFault) {
  start();
  for (int k = 0; k < 10 && governor_.fault() == Fault::kNone; ++k) {
    t_ += 9e-3;
    tick();
  }
  EXPECT_EQ(governor_.fault(), Fault::kLateTick);
}

TEST(MotionGovernor, TicksMayBeLateByItsBudget) {
  MotionGovernor governor(safety());
  double t = 0.0;
  const auto tick = [&](double passed) {
    t += passed;
    governor.admit(resting(t), t);
    governor.moved({}, {}, true);
  };
  tick(kTick);
  tick(0.0219);  // two ticks are on time, 19.9 ms are late
  EXPECT_EQ(governor.fault(), Fault::kNone);
  tick(kTick);  // of which a tenth of what passes is forgiven
  tick(0.0021);
  EXPECT_EQ(governor.fault(), Fault::kNone);
  tick(0.0031);
  EXPECT_EQ(governor.fault(), Fault::kLateTick);
}

TEST(MotionSafety, IsThatOfTheDeviceAndOfItsLimits) {
  DeviceCapabilities device;
  device.rate = 100.0;
  device.force_max = 40.0;
  device.torque_max = 3.0;
  MotionLimits limits;
  limits.velocity = 1.0;
  limits.angular_velocity = 2.0;
  const MotionSafety s = MotionSafety::of(device, limits, 0.01);
  EXPECT_EQ(s.tick, 0.01);
  EXPECT_DOUBLE_EQ(s.reading_period, 0.01);
  EXPECT_DOUBLE_EQ(s.stale_after, 0.03);
  EXPECT_DOUBLE_EQ(s.late_max, 0.03);
  EXPECT_DOUBLE_EQ(s.speed_max, 1.5 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(s.angular_speed_max, 3.0 * std::sqrt(3.0));
  EXPECT_EQ(s.sensor.force_range, 40.0);
  EXPECT_EQ(s.sensor.torque_range, 3.0);
  device.rate = 1000.0;
  EXPECT_EQ(MotionSafety::of(device, limits, 1e-3).stale_after, MotionSafety().stale_after);
  EXPECT_EQ(MotionSafety::of(device, limits, 1e-3).late_max, MotionSafety().late_max);
}

TEST_F(MotionGovernorTest, StopsAndResumesWhenItIsTold) {
  start();
  reading_.user.force = {12.0, 0.0, 0.0};
  run(0.5);
  governor_.stop();
  run(1.0);
  EXPECT_EQ(governor_.fault(), Fault::kEmergencyStop);
  EXPECT_EQ(governor_.state(), GovernorState::kStopped);
  EXPECT_TRUE(controller_.at_rest());
  reading_.user.force.setZero();
  run(2.0);
  EXPECT_EQ(governor_.state(), GovernorState::kStopped);
  governor_.stop(Fault::kPaused);
  governor_.unpause();
  run(1.5);
  EXPECT_EQ(governor_.state(), GovernorState::kStopped) << "unpausing is no resuming";
  governor_.resume();
  run(1.5);
  EXPECT_EQ(governor_.state(), GovernorState::kActive);
}

TEST_F(MotionGovernorTest, TaresWhenItIsTold) {
  start();
  reading_.user.force = {2.5, 0.0, 0.0};  // the bias has drifted, more than the gate lets pass
  governor_.stop(Fault::kChanging);
  run(2.0);
  EXPECT_EQ(governor_.state(), GovernorState::kWaiting);
  governor_.tare();
  run(2.0);
  EXPECT_EQ(governor_.state(), GovernorState::kActive);
  EXPECT_NEAR(governor_.user().force.norm(), 0.0, 1e-12);
}

TEST_F(MotionGovernorTest, LetsNothingThroughThatIsNotFinite) {
  start();
  MotionSetpoint bad = controller_.motion();
  bad.velocity.linear.x() = kNan;
  EXPECT_FALSE(governor_.moved(bad, controller_.motion(), false));
  EXPECT_EQ(governor_.fault(), Fault::kBadForce);
}

TEST_F(MotionGovernorTest, SurvivesAnySequence) {
  std::mt19937_64 random(31);
  controller_.start({});
  spoil_ = [&](MotionReading& r) {
    const auto what = random() % 400;
    if (what < 12) reinterpret_cast<double*>(&r.pose.position)[what % 3] = kNan;
    if (what == 20) r.user.force.setConstant(kNan);
    if (what == 21) r.user.force.setConstant(1e300);
    if (what == 22) r.t = -1.0;
    if (what == 23) r.user_t = kNan;
    if (what == 24) r.hand = static_cast<std::uint32_t>(random());
  };
  AxisLimits limits = controller_.limits().along(0);
  for (int k = 0; k < 100'000; ++k) {
    if (random() % 1000 == 0)
      reading_.user.force = Eigen::Vector3d::Constant(static_cast<double>(random() % 40));
    if (random() % 2000 == 0) governor_.resume();
    const double before = controller_.motion().velocity.linear.x();
    tick();
    ASSERT_LE(std::abs(controller_.motion().velocity.linear.x() - before),
              limits.acceleration * kTick * (1 + 1e-9));
  }
}

TEST_F(MotionGovernorTest, TakesNothingFromTheHeap) {
  start();
  reading_.user.force = {12.0, 0.0, 0.0};
  const test::AllocationGuard guard;
  run(0.5);
  governor_.stop();
  run(0.5);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
