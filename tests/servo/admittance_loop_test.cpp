// What AdmittanceLoop takes the loop of each axis to be.
#include <palpate/servo/admittance_loop.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

#include <support/not_finite.h>
#include <support/tick.h>

namespace palpate {
namespace {

using test::kTick;

/// Stiffer about the axes than along them, and both late.
AdmittanceLoopOptions loop() {
  AdmittanceLoopOptions options;
  options.period = 2e-3;
  options.along.contact_stiffness = 2000.0;
  options.along.delay = 3e-3;
  options.about.contact_stiffness = 20.0;
  options.about.delay = 1e-3;
  return options;
}

/// The least damping of a mass in `model`, half a tick later.
double least(double mass, AdmittanceLoopModel model, const AdmittanceLoopOptions& options) {
  model.delay += 0.5 * options.period;
  return least_damping(mass, model, options.margin);
}

// On every axis by itself, the others with twice of what they need.
TEST(AdmittanceLoopCheck, WantsTheLeastDampingOfEachAxisHalfATickLater) {
  const AdmittanceLoopOptions options = loop();
  const double along = least(options.admittance.mass.x(), options.along, options);
  const double about = least(options.admittance.inertia.x(), options.about, options);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    for (const double share : {0.98, 1.02}) {
      AdmittanceLoopOptions tried = options;
      tried.admittance.damping.setConstant(2.0 * along);
      tried.admittance.angular_damping.setConstant(2.0 * about);
      (axis < 3 ? tried.admittance.damping[axis] : tried.admittance.angular_damping[axis - 3]) =
          share * (axis < 3 ? along : about);
      const std::string name = std::string(axis < 3 ? "along " : "about ") + "xyz"[axis % 3];
      try {
        AdmittanceLoop::check(tried);
        EXPECT_GT(share, 1.0) << name;
      } catch (const Error& error) {
        EXPECT_LT(share, 1.0) << name;
        EXPECT_THAT(error.what(), testing::HasSubstr(name));
      }
    }
  }
}

/// Says nothing until it is told to, and then follows.
struct Quiet final : MotionDevice {
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, MotionReading& reading) override {
    if (!speaks) return false;
    reading.t = reading.user_t = t;
    reading.pose = at;
    return true;
  }
  MotionAnswer move(const MotionSetpoint& motion, double) override {
    at = motion.pose;
    ++moves;
    return {motion};
  }
  void stop() noexcept override {}

  DeviceCapabilities can;
  DevicePose at;
  bool speaks = false;
  int moves = 0;
};

AdmittanceLoopOptions without_margin() {
  AdmittanceLoopOptions options = loop();
  options.admittance.damping = {300.0, 250.0, 400.0};
  options.admittance.angular_damping.setConstant(3.0);
  options.margin = 0.0;
  return options;
}

class AdmittanceLoopTest : public testing::Test {
 protected:
  AdmittanceLoopTest() {
    loop.open();
    loop.enable();
  }
  bool read(int tick) { return loop.read(tick * options.period, reading); }

  AdmittanceLoopOptions options = without_margin();
  Quiet quiet;
  AdmittanceLoop loop{quiet, options};
  DeviceReading reading;
};

TEST(AdmittanceLoopCapabilities, AreOfItsControllersDampingAndItsLoopsDelay) {
  AdmittanceLoopOptions options = without_margin();
  options.along.lag = 4e-3;
  options.along.sensor_lag = 2e-3;
  options.admittance.angular_damping = {0.3, 0.2, 0.4};
  Quiet quiet;
  quiet.can.damping = 7.0;
  quiet.can.force_max = 33.0;
  const AdmittanceLoop loop(quiet, options);
  const DeviceCapabilities& can = loop.capabilities();
  EXPECT_EQ(can.kind, Causality::kAdmittance);
  EXPECT_EQ(can.damping, 250.0);
  EXPECT_EQ(can.angular_damping, 0.2);
  EXPECT_EQ(can.damping_max, 125.0);
  EXPECT_EQ(can.damping_source, DampingSource::kSimulated);
  EXPECT_DOUBLE_EQ(can.delay, 9e-3);
  EXPECT_EQ(can.force_max, 33.0) << "the rest is the device's";
  options.about = options.along;
  options.about.delay += 1e-3;
  EXPECT_DOUBLE_EQ(AdmittanceLoop(quiet, options).capabilities().delay, 10e-3) << "the longer of the two";
}

TEST_F(AdmittanceLoopTest, MovesNothingBeforeTheDeviceHasSpoken) {
  for (int k = 1; k < 10; ++k) {
    EXPECT_FALSE(read(k));
    loop.write({{5, 0, 0}, {}});
  }
  EXPECT_EQ(quiet.moves, 0);
  quiet.speaks = true;
  quiet.at.position = {0.1, 0.2, 0.3};
  EXPECT_TRUE(read(10));
  EXPECT_EQ(reading.pose, quiet.at);
  loop.write({{5, 0, 0}, {}});
  EXPECT_EQ(quiet.moves, 1);
  EXPECT_EQ(quiet.at.position, Eigen::Vector3d(0.1, 0.2, 0.3)) << "the gate is shut";
}

TEST_F(AdmittanceLoopTest, TellsNoReadingThatIsOldAndNoneInAFault) {
  quiet.speaks = true;
  EXPECT_TRUE(read(1));
  quiet.speaks = false;
  EXPECT_FALSE(read(2));
  EXPECT_EQ(loop.status(), DeviceStatus::kEnabled);
  quiet.speaks = true;
  EXPECT_TRUE(read(3));
  loop.stop();
  EXPECT_FALSE(read(4));
  EXPECT_EQ(loop.status(), DeviceStatus::kFault);
}

/// Goes where it is told, under a hand that pushes, and keeps what it was told.
struct MovedHandle final : MotionDevice {
  MovedHandle() {
    can.force_max = 100.0;
    can.torque_max = 10.0;
  }
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, MotionReading& reading) override {
    now = t;
    if (++asked % every != 0) return false;
    reading = {t, at, {}, {push, Eigen::Vector3d::Zero()}, t};
    if (spoil) spoil(reading);
    return true;
  }
  MotionAnswer move(const MotionSetpoint& motion, double) override {
    at = motion.pose;
    told.push_back({now, motion});
    return drifts ? MotionAnswer{*drifts, true, "it drifts"} : MotionAnswer{motion};
  }
  void stop() noexcept override { ++stops; }

  struct Told {
    double t = 0.0;
    MotionSetpoint motion;
  };
  DeviceCapabilities can;
  DevicePose at;
  Eigen::Vector3d push = Eigen::Vector3d::Zero();
  int asked = 0, every = 1;  ///< ticks for a reading
  std::function<void(MotionReading&)> spoil;
  double now = 0.0;
  std::vector<Told> told;
  int stops = 0;
  std::optional<MotionSetpoint> drifts;  ///< motion that it answers with, whatever it is told
};

AdmittanceLoopOptions unchecked() {
  AdmittanceLoopOptions options;
  options.margin = 0.0;
  return options;
}

class MovedHandleTest : public testing::Test {
 protected:
  MovedHandleTest() {
    handle.at.position = kBegin;
    handle.told.reserve(10'000);
    loop.open();
    loop.enable();
  }
  void tick(double passed = kTick) { tick(loop, passed); }
  void tick(AdmittanceLoop& of, double passed = kTick) {
    t += passed;
    DeviceReading reading;
    of.read(t, reading);
    of.write({});
  }
  void run(double time) {
    for (const double end = t + time; t < end;) tick();
  }
  /// Lets the hand push until the handle moves along x at 1 m/s.
  void push() {
    run(1.0);
    ASSERT_EQ(loop.governor().state(), GovernorState::kActive);
    handle.push.x() = 40.0;
    for (int k = 0; k < 1000 && loop.motion().velocity.linear.x() < 1.0; ++k) tick();
    ASSERT_GE(loop.motion().velocity.linear.x(), 1.0);
  }

  /// Setpoints from `first` on brake, and none jumps after a gap.
  void expect_braking_from(std::size_t first, const std::string& name) const {
    const MotionLimits& limits = options.limits;
    for (std::size_t k = first; k < handle.told.size(); ++k) {
      const MovedHandle::Told &now = handle.told[k], &before = handle.told[k - 1];
      const double dt = now.t - before.t, room = 1.0 + 1e-9;
      const Eigen::Vector3d way = now.motion.pose.position - before.motion.pose.position;
      EXPECT_LE((now.motion.velocity.linear - before.motion.velocity.linear).norm(),
                limits.acceleration * dt * room)
          << name;
      EXPECT_LE(way.norm(), limits.velocity * std::min(dt, 2.0 * kTick) * room) << name;
      EXPECT_GE(way.x(), 0.0) << name;
    }
  }

  const Eigen::Vector3d kBegin{0.6, -0.8, 0.5};
  AdmittanceLoopOptions options = unchecked();
  MovedHandle handle;
  AdmittanceLoop loop{handle, options};
  double t = 0.0;
};

// A setpoint before that would be the origin, a metre away.
TEST_F(MovedHandleTest, GetsItsFirstSetpointFromItsFirstValidReading) {
  const std::vector<std::function<void(MotionReading&)>> all{
      [](MotionReading& r) { r.pose.position.y() = test::kNan; },
      [](MotionReading& r) { r.velocity.angular.x() = test::kNan; },
      [](MotionReading& r) { r.pose.orientation.coeffs() *= 2.0; }, [](MotionReading& r) { r.t += 1.0; }};
  for (const auto& spoil : all) {
    handle.spoil = spoil;
    run(0.05);
    EXPECT_TRUE(handle.told.empty());
    EXPECT_EQ(loop.status(), DeviceStatus::kFault);
  }
  handle.spoil = nullptr;
  tick();
  ASSERT_EQ(handle.told.size(), 1U);
  EXPECT_EQ(handle.told.front().motion.pose.position, kBegin);
  run(2.0);
  EXPECT_EQ(handle.told.back().motion.pose.position, kBegin);
  EXPECT_EQ(loop.governor().state(), GovernorState::kActive) << "and comes back through the gate";
}

// A reading of the future may be refused without a fault in that tick.
TEST_F(MovedHandleTest, TellsNoReadingThatItsGovernorHasRefused) {
  handle.spoil = [](MotionReading& r) { r.t += 1.0; };
  DeviceReading reading;
  EXPECT_FALSE(loop.read(kTick, reading));
}

// As where its driver was restarted while somebody carried the handle.
TEST_F(MovedHandleTest, IsNotPulledBackFromWhereItIsFoundAfterAGap) {
  push();
  handle.push.setZero();
  handle.spoil = [](MotionReading& r) { r.pose.position.x() = test::kNan; };
  for (const double gap : {0.003, 0.1, 2.0}) {
    run(gap);
    EXPECT_EQ(loop.governor().fault(), Fault::kBadPose);
    const Eigen::Vector3d elsewhere = handle.at.position + Eigen::Vector3d(0.3, 0.9, -0.2);
    // It ignores what it is told, and for a while its filter makes a velocity of the jump.
    const double found = t;
    handle.spoil = [&](MotionReading& r) {
      r.pose.position = elsewhere;
      r.velocity.linear.x() = 300.0 * std::exp(-(r.t - found) / 0.01);
    };
    const std::size_t before = handle.told.size();
    const int stopped = handle.stops;
    run(0.2);
    EXPECT_EQ(handle.told.size(), before) << gap;
    EXPECT_GT(handle.stops, stopped) << gap;
    handle.spoil = nullptr;
    handle.at.position = elsewhere;
    run(1.5);
    ASSERT_GT(handle.told.size(), before) << gap;
    EXPECT_EQ(handle.told[before].motion.pose.position, elsewhere) << gap;
    EXPECT_EQ(loop.governor().state(), GovernorState::kActive) << gap;
    handle.spoil = [](MotionReading& r) { r.pose.position.x() = test::kNan; };
  }
}

TEST_F(MovedHandleTest, GoesOnBrakingAlongItsSetpointsAfterAJumpOfOneReading) {
  push();
  handle.spoil = [](MotionReading& r) { r.pose.position.x() += 0.5; };
  tick();
  EXPECT_EQ(loop.governor().fault(), Fault::kJump);
  handle.spoil = nullptr;
  const std::size_t before = handle.told.size();
  run(options.limits.stop_time());
  EXPECT_EQ(handle.stops, 0);
  EXPECT_GE(handle.told.size(), before + 237);  // none while it may be elsewhere: not before two agree
  EXPECT_TRUE(loop.motion().velocity.linear.isZero(0.0));
  EXPECT_EQ(loop.governor().fault(), Fault::kJump);
  expect_braking_from(before, "one reading");
}

TEST_F(MovedHandleTest, GoesOnBrakingFromItsLastSetpointAfterReadingsToAndFro) {
  push();
  const std::size_t before = handle.told.size();
  for (int k = 0; k < 15; ++k) {
    handle.spoil = [k](MotionReading& r) { r.pose.position.x() += k % 2 == 0 ? 0.5 : 0.0; };
    tick();
  }
  handle.spoil = nullptr;
  EXPECT_EQ(handle.told.size(), before);
  run(options.limits.stop_time());
  EXPECT_GT(handle.told.size(), before);
  EXPECT_TRUE(loop.motion().velocity.linear.isZero(0.0));
  expect_braking_from(before, "15 readings");
}

// Readings to and fro for longer than that: the handle is elsewhere. The tick in which the motion starts
// again is one without a reading.
TEST_F(MovedHandleTest, MovesAgainAfterReadingsToAndFroThatComeLessOftenThanTicks) {
  handle.every = 4;
  handle.can.rate = 250.0;
  AdmittanceLoop slow(handle, options);
  slow.open();
  slow.enable();
  const auto run_slow = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) tick(slow);
  };
  for (int lead = 0; lead < 4; ++lead) {
    run_slow(2000 + lead);
    ASSERT_EQ(slow.governor().state(), GovernorState::kActive);
    int count = 0;
    handle.spoil = [&count](MotionReading& r) { r.pose.position.x() += ++count % 2 == 0 ? 0.5 : 0.0; };
    run_slow(40);
    EXPECT_EQ(slow.governor().fault(), Fault::kJump);
    handle.spoil = nullptr;
    run_slow(2000);
    const std::size_t told = handle.told.size();
    run_slow(100);
    EXPECT_EQ(slow.governor().state(), GovernorState::kActive) << lead;
    EXPECT_EQ(handle.told.size(), told + 100) << lead;
  }
}

// Ticks that are on time, late once, and late again and again, which is a fault itself.
TEST_F(MovedHandleTest, IsAtRestInTimeHoweverLateTicksAre) {
  const std::vector<std::vector<double>> all{{1e-3},  {2e-3},        {5e-3},
                                             {19e-3}, {0.049},       {1e-3, 2e-3, 5e-3, 19e-3},
                                             {0.12},  {19e-3, 1e-3}, {0.4, 1e-3}};
  const MotionLimits& limits = options.limits;
  for (const std::vector<double>& passed : all) {
    const std::string name = testing::PrintToString(passed);
    push();
    loop.governor().stop(Fault::kChanging);
    const double begin = t;
    const std::size_t first = handle.told.size();
    for (std::size_t k = 0; t < begin + limits.stop_time(); ++k) tick(passed[k % passed.size()]);
    EXPECT_TRUE(loop.motion().velocity.linear.isZero(0.0)) << name;
    EXPECT_TRUE(loop.motion().acceleration.linear.isZero(0.0)) << name;
    expect_braking_from(first, name);
    handle.push.setZero();
    run(1.0);
  }
}

TEST_F(MovedHandleTest, ComesToRestBeforeItsLoopEnds) {
  push();
  const double begin = t;
  while (!loop.come_to_rest() && t < begin + 1.0) {
    loop.governor().resume();
    tick();
  }
  EXPECT_LE(t, begin + options.limits.stop_time() + kTick);
  const MotionSetpoint& last = handle.told.back().motion;
  EXPECT_TRUE(last.velocity.linear.isZero(0.0));
  EXPECT_TRUE(last.still);
  EXPECT_EQ(loop.governor().fault(), Fault::kEnded);
  EXPECT_EQ(loop.status_text(), "") << "nothing has failed";
  EXPECT_EQ(handle.stops, 0);
  tick();
  EXPECT_TRUE(loop.come_to_rest()) << "and stays there under the hand";
  loop.close();
  EXPECT_EQ(handle.stops, 0);
}

TEST_F(MovedHandleTest, IsToldToStopIfItIsNotAtRestInTime) {
  push();
  handle.drifts = loop.motion();
  const double begin = t;
  while (!loop.come_to_rest() && t < begin + 1.0) tick();
  EXPECT_GE(t, begin + options.limits.stop_time());
  EXPECT_LE(t, begin + options.limits.stop_time() + 3.0 * kTick);
  EXPECT_EQ(handle.stops, 1);
}

TEST_F(MovedHandleTest, IsToldToStopIfItIsClosedInMotion) {
  push();
  EXPECT_EQ(handle.stops, 0);
  loop.close();
  EXPECT_EQ(handle.stops, 1);
}

TEST(AdmittanceLoopCheck, WithoutAMarginIsNone) {
  AdmittanceLoopOptions options = loop();
  options.admittance.damping.setZero();
  EXPECT_THROW(AdmittanceLoop::check(options), Error);
  options.margin = 0.0;
  EXPECT_NO_THROW(AdmittanceLoop::check(options));
}

}  // namespace
}  // namespace palpate
