// A room-scale device, the hand that holds it, and what can go wrong between them.
#include <palpate/device/giant_device.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/geometry/rotation.h>
#include <support/giant_trial.h>
#include <support/heap_guard.h>
#include <support/tick.h>
#include <support/wall.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;

/// A person who walks about the room and reaches: recorded motion has the same speeds.
HandPath walk(double begins = 1.5) {
  const Pose home = test::giant_home();
  return [=](double time) {
    const double t = std::max(0.0, time - begins), u = std::min(1.0, t / 3.0), ease = u * u * (3.0 - 2.0 * u);
    Pose pose = home;
    pose.position +=
        ease * Vector3d(1.4 * std::sin(0.21 * t) + 0.12 * std::sin(1.7 * t),
                        1.7 * std::sin(0.17 * t) + 0.1 * std::sin(2.3 * t), 0.15 * std::sin(0.9 * t));
    pose.orientation = rotation_by(ease * Vector3d(0.3 * std::sin(0.7 * t), 0.3 * std::sin(1.1 * t),
                                                   0.6 * std::sin(0.4 * t))) *
                       pose.orientation;
    return pose;
  };
}

/// What spoils readings on their way from the device.
class Spoiled final : public MotionDevice {
 public:
  explicit Spoiled(MotionDevice& device) : device_(device) {}
  const DeviceCapabilities& capabilities() const override { return device_.capabilities(); }
  bool read(double t, MotionReading& reading) override {
    const bool fresh = device_.read(t, reading);
    if (fresh && spoil) spoil(reading);
    return fresh;
  }
  MotionAnswer move(const MotionSetpoint& motion, double dt) override { return device_.move(motion, dt); }
  void stop() noexcept override { device_.stop(); }
  std::function<void(MotionReading&)> spoil;

 private:
  MotionDevice& device_;
};

class GiantDeviceTest : public testing::Test {
 protected:
  void hold(HandPath path, const GiantProperties& properties = {}, const MotionLimits& limits = {}) {
    const GripProperties grip{hand_, 0.05};
    device_ = std::make_unique<GiantDevice>(test::giant(),
                                            test::own_plant(properties.drives, grip, std::move(path)),
                                            properties, test::giant_home());
    spoiled_ = std::make_unique<Spoiled>(*device_);
    AdmittanceLoopOptions options;
    options.along = loop_model(test::giant(), properties);
    options.about = loop_model(test::giant(), properties);
    options.along.hand_mass = hand_.mass;
    options.along.hand_damping = hand_.damping;
    options.along.hand_stiffness = hand_.stiffness;
    options.limits = limits;
    loop_ = std::make_unique<AdmittanceLoop>(*spoiled_, options);
    tick_ = std::make_unique<ServoTick>(*loop_, FeltModel{&wall_});
  }
  /// One tick, after which every joint is within its limits.
  void tick() {
    const JointVector dq = device_->joints().velocity();
    tick_->run(kTick * count_++);
    const ChainLimits& l = device_->joints().limits();
    const JointVector &q = device_->joints().position(), &speed = device_->joints().velocity();
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      ASSERT_TRUE(q[i] >= l.lower[i] && q[i] <= l.upper[i]);
      ASSERT_LE(std::abs(speed[i]), l.velocity[i] * (1 + 1e-9));
      ASSERT_LE(std::abs(speed[i] - dq[i]), l.acceleration[i] * kTick * (1 + 1e-9) + 1e-12);
    }
  }
  void run(double time) {
    const int ticks = static_cast<int>(std::lround(time / kTick));
    for (int k = 0; k < ticks; ++k) tick();
  }

  test::Wall wall_{0.0};
  HandProperties hand_ = test::kOperators[2];
  std::unique_ptr<GiantDevice> device_;
  std::unique_ptr<Spoiled> spoiled_;
  std::unique_ptr<AdmittanceLoop> loop_;
  std::unique_ptr<ServoTick> tick_;
  int count_ = 0;
};

TEST_F(GiantDeviceTest, FollowsAPersonForMinutesWithoutAFault) {
  const HandPath path = walk();
  hold(path);
  double farthest = 0.0, hardest = 0.0;
  for (int k = 0; k < 180'000; ++k) {
    tick();
    ASSERT_EQ(loop_->governor().fault(), Fault::kNone) << kTick * k;
    ASSERT_EQ(tick_->governor().fault(), Fault::kNone) << kTick * k;
    farthest = std::max(farthest, (device_->pose().position - path(kTick * k).position).norm());
    hardest = std::max(hardest, device_->hand().force.norm());
  }
  EXPECT_LT(hardest, 25.0);  // 0.6 m/s against 25 N s/m, and what accelerates the virtual mass
  EXPECT_LT(farthest, 0.1);  // which stretches the arm's spring of 400 N/m
}

TEST_F(GiantDeviceTest, RefusesToBeginWhereItCannotReach) {
  Pose far;
  far.position = {9.0, 0.0, 1.0};
  try {
    GiantDevice(test::giant(), test::own_plant({}, {}, walk()), {}, far);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("giant"), testing::HasSubstr("9.000")));
  }
  GiantProperties late;
  late.delay = 0.1;
  EXPECT_THROW(GiantDevice(test::giant(), test::own_plant({}, {}, walk()), late, test::giant_home()), Error);
}

TEST_F(GiantDeviceTest, HoldsAtTheEndOfTheRoomAndSaysWhy) {
  const Pose home = test::giant_home();
  hand_ = test::kOperators[0];
  hold([home](double t) {
    Pose pose = home;
    pose.position.x() += std::clamp(t - 1.5, 0.0, 4.0);  // more than there is, the arm's length included
    if (t > 12.0) pose.position.x() -= std::min(1.5, 0.5 * (t - 12.0));
    return pose;
  });
  run(12.0);
  EXPECT_EQ(loop_->governor().fault(), Fault::kNone);
  EXPECT_STREQ(loop_->held_by(), "position limit");
  EXPECT_GT(device_->hand().force.x(), 20.0);
  run(1.0);
  EXPECT_LT(device_->hand().force.x(), 1e3);
  run(5.0);  // and comes away without a jump: tick() has looked at every one
  EXPECT_STREQ(loop_->held_by(), "");
  EXPECT_EQ(loop_->governor().fault(), Fault::kNone);
}

TEST_F(GiantDeviceTest, StaysInItsWorkspace) {
  const Pose home = test::giant_home();
  MotionLimits limits;
  limits.workspace =
      Eigen::AlignedBox3d(home.position - Vector3d::Constant(0.2), home.position + Vector3d::Constant(0.2));
  hold(
      [home](double t) {
        Pose pose = home;
        pose.position += std::clamp(t - 1.5, 0.0, 1.0) * Vector3d(0.3, -0.25, 0.0);
        return pose;
      },
      {}, limits);
  run(6.0);
  EXPECT_NEAR(loop_->motion().pose.position.x(), home.position.x() + 0.2, 1e-3);
  EXPECT_NEAR(loop_->motion().pose.position.y(), home.position.y() - 0.2, 1e-3);
  EXPECT_EQ(loop_->governor().fault(), Fault::kNone);
}

TEST_F(GiantDeviceTest, BiasIsTaredAndDriftMovesTheHandleByDriftOverDamping) {
  GiantProperties properties;
  properties.sensor.bias.force = {2.0, -1.0, 0.5};
  properties.sensor.bias.torque = {0.1, 0.0, -0.1};
  const Pose home = test::giant_home();
  hand_ = {0.05, 0.0, 0.0};  // nobody holds it
  hold([home](double) { return home; }, properties);
  run(3.0);
  EXPECT_EQ(loop_->governor().state(), GovernorState::kActive);
  EXPECT_LT((device_->pose().position - home.position).norm(), 2e-3);
  EXPECT_LT((loop_->governor().bias().force - properties.sensor.bias.force).norm(), 0.01);
  properties.sensor.drift.force = {0.1, 0.0, 0.0};
  count_ = 0;
  hold([home](double) { return home; }, properties);
  run(11.0);
  // Tared 0.2 s after the start, it says 1 N ten seconds later, which the virtual damper turns into 4 cm/s.
  EXPECT_NEAR(loop_->motion().velocity.linear.x(), 0.1 * 10.8 / 25.0, 3e-3);
}

TEST_F(GiantDeviceTest, BadSensorsBringItToRest) {
  struct Wrong {
    const char* name;
    SensorFault fault;
    std::function<void(MotionReading&)> spoil;
  };
  const std::vector<Wrong> all{
      {"NaN", SensorFault::kNotFinite, [](MotionReading& r) { r.user.force.setConstant(std::nan("")); }},
      {"spikes", SensorFault::kSpike,
       [](MotionReading& r) { r.user.force.y() += std::lround(1e3 * r.t) % 2 != 0 ? 1e5 : -1e5; }},
      {"dropout", SensorFault::kDropout, [](MotionReading& r) { r.user_t = 0.0; }},
      {"saturation", SensorFault::kSaturated,
       [push = 0.0](MotionReading& r) mutable { r.user.force.z() = push = std::min(150.0, push + 5.0); }}};
  for (const Wrong& wrong : all) {
    count_ = 0;
    hold(walk());
    run(4.0);
    ASSERT_EQ(loop_->governor().fault(), Fault::kNone) << wrong.name;
    spoiled_->spoil = wrong.spoil;
    double until = 0.2;
    while (loop_->governor().fault() == Fault::kNone && until > 0.0) {
      tick();
      until -= kTick;
    }
    EXPECT_EQ(loop_->governor().fault(), Fault::kForceSensor) << wrong.name;
    EXPECT_EQ(loop_->governor().sensor_fault(), wrong.fault) << wrong.name;
    run(MotionLimits{}.stop_time() + 0.01);
    EXPECT_TRUE(loop_->motion().velocity.linear.isZero(0.0)) << wrong.name;
    EXPECT_TRUE(device_->joints().velocity().isZero(0.0)) << wrong.name;
  }
}

TEST_F(GiantDeviceTest, OneSpikeIsNotFelt) {
  hold(walk());
  run(6.0);
  spoiled_->spoil = [](MotionReading& r) {
    if (std::lround(1e3 * r.t) % 100 == 0) r.user.force.x() += 120.0;
  };
  Vector3d before = loop_->motion().acceleration.linear;
  for (int k = 0; k < 2000; ++k) {
    tick();
    const Vector3d& now = loop_->motion().acceleration.linear;
    ASSERT_LT((now - before).norm(), 0.15);  // 120 N would be 80 m/s^2
    before = now;
  }
  EXPECT_EQ(loop_->governor().fault(), Fault::kNone);
}

TEST_F(GiantDeviceTest, StopsWhenItsLoopStandsStill) {
  hold(walk());
  run(6.0);
  EXPECT_GT(device_->joints().velocity().norm(), 0.05);
  MotionReading reading;
  for (int k = 0; k < 400; ++k) device_->read(kTick * count_++, reading);  // nobody moves it
  EXPECT_EQ(device_->joints().velocity().norm(), 0.0);
  EXPECT_LT(reading.velocity.linear.norm(), 0.03);  // the hand that goes on bends what is between
}

// The setpoint goes on from where the joints have braked, which takes the time of the gap once.
TEST_F(GiantDeviceTest, GoesOnFromWhereItBrakedWhileCommandsWereLate) {
  hold(walk());
  run(6.0);
  const JointVector dq = device_->joints().velocity();
  constexpr int kGap = 60;  // ticks, more than kWatchdog
  count_ += kGap - 1;
  tick_->run(kTick * count_++);
  EXPECT_NE(loop_->governor().state(), GovernorState::kActive);
  EXPECT_STREQ(loop_->held_by(), "commands were late");
  EXPECT_EQ(loop_->motion().pose.position, device_->joints().tip().position);
  const ChainLimits& l = device_->joints().limits();
  for (Eigen::Index i = 0; i < dq.size(); ++i)
    EXPECT_LE(std::abs(device_->joints().velocity()[i] - dq[i]),
              l.acceleration[i] * kGap * kTick * (1 + 1e-9));
  run(MotionLimits{}.stop_time());
  EXPECT_TRUE(device_->joints().velocity().isZero(0.0));
}

TEST_F(GiantDeviceTest, BrakesWhenItIsToldToStopAndComesBackThroughTheGate) {
  hold(walk());
  run(6.0);
  tick_->stall();
  run(1.0);
  EXPECT_NE(loop_->governor().state(), GovernorState::kActive);
  EXPECT_TRUE(loop_->motion().velocity.linear.isZero(1e-6));
}

TEST_F(GiantDeviceTest, ATickTakesNothingFromTheHeap) {
  wall_.k = 1000.0;
  hold(walk());
  run(2.0);
  const test::HeapGuard guard;
  for (int k = 0; k < 2000; ++k) tick_->run(kTick * count_++);
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(GiantDeviceTest, AdmittancesThatAreNotStableAreRefusedAlsoOnTheWay) {
  hold(walk());
  Admittance light;
  light.mass.setConstant(0.05);
  light.damping.setConstant(0.5);
  EXPECT_THROW(loop_->change(light, 500.0), Error);
  Admittance heavy;
  heavy.mass.setConstant(4.0);
  heavy.damping.setConstant(60.0);
  EXPECT_NO_THROW(loop_->change(heavy, 2000.0));
  run(2.0);
  EXPECT_NEAR(loop_->admittance().mass.x(), 4.0, 1e-6);
  EXPECT_THROW(loop_->change({}, 20'000.0), Error);
}

// The loop counts on the damping that it was told of.
TEST_F(GiantDeviceTest, HasTheDampingThatItTellsOfHoweverItIsChanged) {
  hold(walk());
  const double told = loop_->capabilities().damping;
  Admittance lighter = loop_->admittance();
  lighter.damping.setConstant(0.8 * told);
  lighter.angular_damping *= 0.8;
  loop_->change(lighter, 100.0);
  run(2.0);
  EXPECT_GE(loop_->admittance().damping.minCoeff(), loop_->capabilities().damping);
  EXPECT_GE(loop_->admittance().angular_damping.minCoeff(), loop_->capabilities().angular_damping);
}

// ThreadSanitizer looks on.
TEST_F(GiantDeviceTest, IsChangedStoppedAndResumedFromAnotherThread) {
  wall_.k = 500.0;
  hold(walk());
  std::atomic<bool> ends = false;
  std::thread other([&] {
    for (int k = 0; !ends; ++k) {
      Admittance admittance;
      admittance.damping.setConstant(k % 2 == 0 ? 40.0 : 60.0);
      loop_->change(admittance, 500.0);
      if (k % 8 == 0) {
        loop_->stop();
      } else {
        loop_->governor().resume();
      }
      if (k % 5 == 0) loop_->governor().tare();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  run(3.0);
  ends = true;
  other.join();
  EXPECT_TRUE(device_->pose().position.allFinite());
}

}  // namespace
}  // namespace palpate
