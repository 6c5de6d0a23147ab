// What AdmittanceLoop takes the loop of each axis to be.
#include <palpate/servo/admittance_loop.h>

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

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
  Quiet quiet;
  quiet.can.damping = 7.0;
  quiet.can.force_max = 33.0;
  const AdmittanceLoop loop(quiet, options);
  const DeviceCapabilities& can = loop.capabilities();
  EXPECT_EQ(can.kind, Causality::kAdmittance);
  EXPECT_EQ(can.damping, 250.0);
  EXPECT_EQ(can.damping_max, 125.0);
  EXPECT_EQ(can.damping_source, DampingSource::kSimulated);
  EXPECT_DOUBLE_EQ(can.delay, 9e-3);
  EXPECT_EQ(can.force_max, 33.0) << "the rest is the device's";
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

TEST(AdmittanceLoopCheck, WithoutAMarginIsNone) {
  AdmittanceLoopOptions options = loop();
  options.admittance.damping.setZero();
  EXPECT_THROW(AdmittanceLoop::check(options), Error);
  options.margin = 0.0;
  EXPECT_NO_THROW(AdmittanceLoop::check(options));
}

}  // namespace
}  // namespace palpate
