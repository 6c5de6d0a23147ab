#include <palpate/servo/servo_tick.h>

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/study/procedural.h>

#include "support/allocation_guard.h"
#include "support/tick.h"
#include "support/wall.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;
using test::Wall;

/// A device whose handle is where the test puts it.
struct Handle final : HapticDevice {
  Handle() {
    can.force_max = 10.0;
    can.torque_max = 0.5;
    can.damping = 2.0;
    can.damping_max = 20.0;
  }
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, DeviceReading& reading) override {
    if (silent || t < said + period - 1e-9) return false;
    said = t;
    reading = {t, DevicePose(pose), {}};
    reading.pose.position.y() += 1e-6 * std::sin(100.0 * t);  // a hand is never still
    return true;
  }
  void write(const Wrench& wrench) override { shown = wrench; }

  DeviceCapabilities can;
  Pose pose;
  Wrench shown;
  bool silent = false;
  double period = 0.0, said = 0.0;  ///< between readings, and the last. Unit: [s].
};

/// A rod of 40 mm along the tool's z against the same wall; its torque is not shown by every device.
struct Rod final : ForceModel {
  bool wants_contacts() const override { return false; }
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    const Vector3d along = input.tool.orientation * Vector3d(0, 0, 0.02);
    const Vector3d tip = along.x() > 0.0 ? Vector3d(-along) : along;
    const double depth = std::max(0.0, -(input.tool.position.x() + tip.x()));
    ForceOutput out;
    out.wrench.force.x() = 500.0 * depth;
    out.wrench.torque = tip.cross(out.wrench.force);
    out.proxy = input.tool;
    out.stored_energy = 0.5 * 500.0 * depth * depth;
    out.stiffness = depth > 0.0 ? 500.0 : 0.0;
    return out;
  }
};

class ServoTickTest : public testing::Test {
 protected:
  const TickRecord& run(double seconds) {
    const TickRecord* record = nullptr;
    for (int k = 0; k < std::lround(seconds / kTick); ++k)
      record = &loop->run(kTick * static_cast<double>(++count));
    return *record;
  }
  void begin(const ServoTickOptions& options = {}) {
    loop = std::make_unique<ServoTick>(device, FeltModel{&wall, &contacts}, options);
  }
  /// Puts the handle there within 20 ms, as fast as a hand might.
  void go_to(double x) {
    const double from = device.pose.position.x();
    for (int k = 1; k <= 20; ++k) {
      device.pose.position.x() = from + (x - from) * k / 20.0;
      run(kTick);
    }
  }

  SceneIndex index{make_scene(*make_surface("sphere"), {}), {}, {}};
  ToolTracker contacts{index, Tool{}};
  Handle device;
  Wall wall{500.0};
  std::unique_ptr<ServoTick> loop;
  int count = 0;
};

TEST_F(ServoTickTest, WhatTheModelAsksForIsSentOnceTheGateIsOpen) {
  begin();
  device.pose.position.x() = 0.01;
  EXPECT_EQ(run(1.0).state, GovernorState::kActive);
  go_to(-0.01);
  const TickRecord& now = run(0.05);
  EXPECT_NEAR(device.shown.force.x(), 5.0, 1e-3);
  EXPECT_NEAR(now.sent_world.force.x(), 5.0, 1e-3);
  EXPECT_DOUBLE_EQ(now.felt.stiffness, 500.0);
  EXPECT_NEAR(now.margin, 3.0 / (0.5 * kTick) / 500.0, 1e-6);  // b / (T / 2) over K
}

TEST_F(ServoTickTest, KeepsItsGainWhereAnotherIsNone) {
  begin();
  loop->set_gain(0.5);
  for (const double none : {-0.5, std::numeric_limits<double>::infinity(), std::nan("")}) {
    loop->set_gain(none);
    EXPECT_EQ(loop->wanted_gain(), 0.5) << none;
  }
  loop->set_gain(0.0);
  EXPECT_EQ(loop->wanted_gain(), 0.0);
}

TEST_F(ServoTickTest, ALaterForceIsALesserMargin) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  loop->set_delay(0.5e-3);
  EXPECT_NEAR(run(0.01).margin, 3.0 / 1e-3 / 500.0, 1e-6);
}

// Who renders it without this loop's delay needs no softer one, and gets none where a fault holds the force.
TEST_F(ServoTickTest, TheLocalSurfaceIsAsStiffAsItIsSetHoweverLateTheForce) {
  begin();
  EXPECT_EQ(run(0.02).force_scale, 0.0) << "the gate";
  run(1.0);
  loop->set_delay(0.02);
  go_to(-0.005);
  const TickRecord& pressed = run(1.0);
  EXPECT_EQ(pressed.felt.local.stiffness, wall.k);
  EXPECT_LT(pressed.felt.stiffness, 0.5 * wall.k);
  EXPECT_EQ(pressed.force_scale, 1.0);
  loop->set_gain(0.5);
  EXPECT_EQ(run(kTick).felt.local.stiffness, 0.5 * wall.k);
  loop->governor().stop();
  const TickRecord& stopped = run(kTick);
  EXPECT_EQ(stopped.force_scale, 0.0);
  EXPECT_EQ(stopped.felt.local.count, 0U);
  EXPECT_GT(stopped.felt.local.stiffness, 0.0) << "of no plane, and not another kind of force";
}

TEST_F(ServoTickTest, MotorsThatAreLateAreALesserMargin) {
  device.can.delay = 0.5e-3;
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  EXPECT_NEAR(run(0.01).margin, 3.0 / 1e-3 / 500.0, 1e-6);
}

TEST_F(ServoTickTest, TheGainIsThereWithoutAJump) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  run(0.05);
  loop->set_gain(0.5);
  double before = device.shown.force.x();
  for (int k = 0; k < 1000; ++k) {
    run(kTick);
    EXPECT_LE(std::abs(device.shown.force.x() - before), 0.05);
    before = device.shown.force.x();
  }
  EXPECT_NEAR(before, 2.5, 0.01);
  EXPECT_EQ(run(kTick).state, GovernorState::kActive);
}

// (500 N/m) (10 mm)^2 / 2 = 25 mJ, which the hand has put in, are 7.07 mm at 1000 N/m.
TEST_F(ServoTickTest, AStifferSpringUnderAHandHasNoMoreEnergy) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  run(0.05);
  loop->set_gain(2.0);
  run(2.0);
  EXPECT_NEAR(device.shown.force.x(), 5.0 * std::sqrt(2.0), 0.01);
  EXPECT_NEAR(loop->count_contacts().felt.stored_energy, 0.025, 1e-4);
  go_to(-0.008);  // by 2 of 7.07 mm
  run(0.05);
  EXPECT_NEAR(device.shown.force.x(), 1000.0 * (0.00707 - 0.002), 0.01);
  go_to(0.01);
  go_to(-0.008);
  run(0.05);
  EXPECT_NEAR(device.shown.force.x(), 1000.0 * 0.008, 0.01) << "pressed anew, it is as stiff as it was set";
  EXPECT_NEAR(loop->count_contacts().felt.stored_energy, 0.5 * 1000.0 * 0.008 * 0.008, 1e-4);
}

// What the loop makes of a model is what a passivity controller of the device's rate, damping and arm makes
// of it.
TEST_F(ServoTickTest, ThePassivityControllerIsThatOfTheDevice) {
  device.can.damping = 0.2;
  ServoTickOptions options;
  options.keeps_passive = false;
  device.can.angular_damping = 0.3e-3;
  begin(options);
  device.pose.position.x() = 0.01;
  run(1.0);
  PassivityController reference(1.0 / device.can.rate, 0.2, 20.0, 0.5 / 10.0, 0.3e-3);
  TickRecord before = run(kTick);
  reference.correct(before.felt.wrench, before.felt.stored_energy, before.sent, before.reading.pose, kTick);
  int damped = 0;
  for (int k = 0; k < 400; ++k) {
    device.pose.position.x() = 0.01 * std::cos(0.1 * k);
    const TickRecord& now = run(kTick);
    reference.correct(now.felt.wrench, now.felt.stored_energy, before.sent, now.reading.pose,
                      now.reading.t - before.reading.t);
    ASSERT_NEAR(now.added_damping, reference.added_damping(), 1e-9 * reference.added_damping()) << k;
    damped += now.added_damping > 0.0 ? 1 : 0;
    before = now;
  }
  EXPECT_EQ(before.state, GovernorState::kActive);
  EXPECT_GT(damped, 50);
}

// A hand that presses on what is soft and lets go of what is stiff, and the other way round, over and over.
TEST_F(ServoTickTest, NoEnergyComesOutOfAGainThatChanges) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  double work = 0.0, x = 0.01, force = 0.0;
  for (int k = 0; k < 4000; ++k) {
    if (k % 50 == 0) loop->set_gain(k % 350 == 0 ? 0.3 : 1.5);
    device.pose.position.x() = 0.002 + 0.008 * std::cos(0.02 * k);
    run(kTick);
    const double now = device.shown.force.x();
    work += 0.5 * (force + now) * (device.pose.position.x() - x);
    x = device.pose.position.x();
    force = now;
    EXPECT_LT(work, 1e-4);
  }
  EXPECT_LT(work, -1e-3) << "was never pressed";
}

// Each by itself would turn the handle: 50 N and 1 N m are wanted, 10 N and 0.5 N m can be shown.
TEST_F(ServoTickTest, AWrenchThatIsTooLargeIsShownInItsProportions) {
  Rod rod;
  loop = std::make_unique<ServoTick>(device, FeltModel{&rod, &contacts});
  device.pose.position.x() = 0.001;
  run(1.0);
  for (int k = 0; k < 200; ++k) {
    device.pose.position.x() -= 0.0005;
    run(kTick);
  }
  const TickRecord& now = run(0.2);
  ASSERT_EQ(now.fault, Fault::kNone);
  ASSERT_GT(now.felt.wrench.torque.norm(), 1.5 * device.can.torque_max);
  EXPECT_NEAR(device.shown.force.norm(), device.can.force_max, 1e-3);
  EXPECT_NEAR(device.shown.torque.norm(), 0.02 * device.shown.force.norm(), 1e-4);
}

// Laid flat just above the wall, turned upright into it, lifted, laid flat, lowered: without a torque, no
// work was done in turning, and none may come out in lifting.
TEST_F(ServoTickTest, NoEnergyComesOutOfATurnThatIsNotFelt) {
  Rod rod;
  for (const double torque_max : {0.0, 0.5}) {
    device.can.torque_max = torque_max;
    loop = std::make_unique<ServoTick>(device, FeltModel{&rod, &contacts});
    const Pose flat{{0.001, 0, 0}, Eigen::Quaterniond::Identity()};
    device.pose = flat;
    run(1.0);
    double out = 0.0, force_out = 0.0;  // of a stroke, by turning and by lifting. Unit: [J].
    const auto go = [&](double x, double turn) {
      const Pose from = device.pose;
      const double had = 2.0 * std::atan2(from.orientation.y(), from.orientation.w());
      for (int k = 1; k <= 500; ++k) {
        const Pose before = device.pose;
        const Wrench held = device.shown;
        device.pose.position.x() = from.position.x() + (x - from.position.x()) * k / 500.0;
        device.pose.orientation = Eigen::AngleAxisd(had + (turn - had) * k / 500.0, Vector3d::UnitY());
        force_out += held.force.dot(device.pose.position - before.position);
        out += held.torque.y() * (turn - had) / 500.0;
        run(kTick);
      }
    };
    for (int stroke = 0; stroke < 5; ++stroke) {
      out = force_out = 0.0;
      go(0.001, std::numbers::pi / 2);
      go(0.025, std::numbers::pi / 2);
      go(0.025, 0.0);
      go(0.001, 0.0);
      EXPECT_LT(out + force_out, 1e-3) << "stroke " << stroke << ", torque " << torque_max;
    }
    // What the hand does put in, it gets back: pressed upright.
    go(0.025, std::numbers::pi / 2);
    go(0.010, std::numbers::pi / 2);
    EXPECT_NEAR(device.shown.force.x(), 5.0, 0.05) << torque_max;
  }
}

TEST_F(ServoTickTest, ATorqueThatCannotBeShownAddsNoDamping) {
  struct Twister final : ForceModel {
    bool wants_contacts() const override { return false; }
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override {
      ForceOutput out;
      out.wrench.torque = {0, 0, 0.1};
      out.proxy = input.tool;
      out.stored_energy = 1.0;
      return out;
    }
  } twister;
  device.can.torque_max = 0.0;
  loop = std::make_unique<ServoTick>(device, FeltModel{&twister, &contacts});
  run(0.1);
  for (int k = 0; k < 500; ++k) {
    device.pose.position.x() += 1e-4;
    device.pose.orientation = Eigen::AngleAxisd(-0.002 * k, Vector3d::UnitZ());
    EXPECT_EQ(run(kTick).added_damping, 0.0);
  }
}

// One tick in five: a force is held for 5 ms.
TEST_F(ServoTickTest, AForceThatIsHeldForLongerIsALesserMargin) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  count += 4;
  EXPECT_NEAR(run(kTick).margin, 12.0, 0.5) << "one late tick is not the rule";
  ServoTickOptions slow;
  slow.period = 5e-3;
  begin(slow);
  device.pose.position.x() = 0.01;
  const auto run_slowly = [&](double seconds) {
    for (int k = 0; k < std::lround(seconds / slow.period); ++k) {
      count += 4;
      run(kTick);
    }
  };
  run_slowly(2.0);
  device.pose.position.x() = 0.0;
  run_slowly(0.05);
  device.pose.position.x() = -0.005;
  run_slowly(0.05);
  EXPECT_NEAR(run(kTick).margin, 3.0 / (0.5 * 5.0 * kTick) / 500.0, 0.05);
}

// (0 + 1) N s/m of a hand that holds a tracker of 60 Hz: 120 N/m, and not the 500 that were set.
TEST_F(ServoTickTest, ASlowDeviceGetsWhatItCanHold) {
  device.can.damping = 0.0;
  device.can.rate = 60.0;
  device.period = 1.0 / 60.0;
  begin();
  device.pose.position.x() = 0.01;
  run(2.0);
  go_to(-0.01);
  const TickRecord& now = run(1.0);
  EXPECT_EQ(now.fault, Fault::kNone);
  EXPECT_NEAR(device.shown.force.x(), 120.0 * 0.01, 0.03);
  EXPECT_NEAR(now.margin, 120.0 / 500.0, 0.005);
  // Quicker again, it is as stiff as it was set.
  device.period = 0.0;
  go_to(0.01);
  run(3.0);
  go_to(-0.01);
  EXPECT_NEAR(run(1.0).felt.stiffness, 500.0, 1.0);
}

// Along, (2 + 1) N s/m hold 6000 N/m at 1 kHz; about, (0.0011 + 0.0009) N m s/rad hold 4 N m/rad.
TEST(PassiveStiffness, OfADeviceInAHand) {
  DeviceCapabilities can;
  can.damping = 2.0;
  can.angular_damping = 1.1e-3;
  const PassiveStiffness of_three = ServoTick::passive_stiffness(can, 1e-3);
  EXPECT_DOUBLE_EQ(of_three.along, 6000.0);
  EXPECT_TRUE(std::isinf(of_three.about)) << "no torque is shown";
  EXPECT_TRUE(std::isinf(ServoTick::longest_arm(can, 500.0, 1e-3)));
  can.torque_max = 0.5;
  EXPECT_DOUBLE_EQ(ServoTick::passive_stiffness(can, 1e-3).about, 4.0);
  EXPECT_NEAR(ServoTick::longest_arm(can, 500.0, 1e-3), std::sqrt(4.0 / 1000.0), 1e-12);
  EXPECT_NEAR(ServoTick::longest_arm(can, 5000.0, 1e-3), std::sqrt(4.0 / 6000.0), 1e-12)
      << "both use five sixths of their bounds";
  can.delay = 1.5e-3;
  EXPECT_DOUBLE_EQ(ServoTick::passive_stiffness(can, 1e-3).about, 1.0);
  EXPECT_DOUBLE_EQ(ServoTick::passive_stiffness(can, 1e-3, 2e-3).along, 750.0);
}

// A spring of 500 N/m and 3 N m/rad on a device that holds 6000 N/m or 3.6 N m/rad: at twice the size of the
// hand's world, a quarter of the latter.
TEST_F(ServoTickTest, TorqueCountsWhereItIsShown) {
  struct Torsion final : ForceModel {
    explicit Torsion(ForceModel& of) : model(of) {}
    bool wants_contacts() const override { return false; }
    void reset() override { model.reset(); }
    ForceOutput evaluate(const ForceInput& input) override {
      ForceOutput out = model.evaluate(input);
      if (out.stiffness > 0.0) out.angular_stiffness = 3.0;
      out.at_lever = at_lever;
      return out;
    }
    ForceModel& model;
    bool at_lever = false;
  } torsion(wall);
  device.can.angular_damping = 0.9e-3;
  for (const auto& [torque_max, at_lever] :
       {std::pair(0.5, false), std::pair(0.5, true), std::pair(0.0, true)}) {
    for (const double scale : {1.0, 2.0}) {
      torsion.at_lever = at_lever;
      device.can.torque_max = torque_max;
      ServoTickOptions options;
      options.map.scale = scale;
      loop = std::make_unique<ServoTick>(device, FeltModel{&torsion, &contacts}, options);
      device.pose.position.x() = 0.001;
      run(2.0);
      device.pose.position.x() = -0.001;
      const TickRecord& first = run(kTick);
      const double along = 500.0 / 6000.0;
      const double about = torque_max > 0.0 ? 3.0 / (scale * scale) / 3.6 : 0.0;
      ASSERT_EQ(first.fault, Fault::kNone) << traits(first.fault).name;
      EXPECT_NEAR(first.margin, 1.0 / (at_lever ? along + about : std::max(along, about)),
                  1e-3 * first.margin);
      const double gain = std::min(1.0, first.margin);
      EXPECT_NEAR(first.felt.stiffness, 500.0 * gain, 1.0) << "soft from the start";
      EXPECT_NEAR(first.felt.angular_stiffness, 3.0 * gain, 0.01);
    }
  }
}

// A force model may have a little energy in reserve before it touches anything: that is no contact.
TEST_F(ServoTickTest, ASlowDeviceGetsNoMoreInTheFirstTickOfAContact) {
  struct Reserve final : ForceModel {
    explicit Reserve(ForceModel& of) : model(of) {}
    bool wants_contacts() const override { return false; }
    void reset() override { model.reset(); }
    ForceOutput evaluate(const ForceInput& input) override {
      ForceOutput out = model.evaluate(input);
      out.stored_energy += 2e-4;
      return out;
    }
    ForceModel& model;
  } reserve(wall);
  device.can.damping = 0.0;
  device.can.rate = 60.0;
  device.period = 1.0 / 60.0;
  loop = std::make_unique<ServoTick>(device, FeltModel{&reserve, &contacts}, ServoTickOptions{});
  device.pose.position.x() = 0.01;
  run(2.0);
  device.pose.position.x() = -0.005;
  double stiffest = 0.0;
  for (int tick = 0; tick < 100; ++tick) stiffest = std::max(stiffest, run(kTick).felt.stiffness);
  EXPECT_NEAR(stiffest, 120.0, 5.0);
}

TEST_F(ServoTickTest, NoGateOpensBeforeTheModelKnows) {
  struct Slow final : ForceModel {
    bool wants_contacts() const override { return false; }
    void reset() override { asked = 0; }
    ForceOutput evaluate(const ForceInput& input) override {
      ForceOutput out;
      out.proxy = input.tool;
      out.is_known = ++asked > 150;
      out.wrench.force.x() = out.is_known ? force : 0.0;
      return out;
    }
    int asked = 0;
    double force = 5.0;
  } slow;
  loop = std::make_unique<ServoTick>(device, FeltModel{&slow, &contacts}, ServoTickOptions{});
  for (int tick = 0; tick < 1000; ++tick) ASSERT_EQ(run(kTick).state, GovernorState::kWaiting) << tick;
  slow.force = 0.0;
  EXPECT_EQ(run(1.0).state, GovernorState::kActive);
}

TEST_F(ServoTickTest, AModelIsToldWhatDampingTheDeviceShows) {
  struct Listener final : ForceModel {
    bool wants_contacts() const override { return false; }
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override {
      damping_max = input.damping_max;
      ForceOutput out;
      out.proxy = input.tool;
      return out;
    }
    double damping_max = 0.0;
  } listener;
  ServoTickOptions options;
  options.gain = 4.0;
  loop = std::make_unique<ServoTick>(device, FeltModel{&listener, &contacts}, options);
  run(0.1);
  EXPECT_DOUBLE_EQ(listener.damping_max, 5.0);  // 20 N s/m, of forces that are felt four times as large
  loop->set_delay(9.5e-3);                      // 0.05 kg / (0.5 ms + 9.5 ms) = 5 N s/m
  run(kTick);
  EXPECT_NEAR(listener.damping_max, 1.25, 1e-9);
  loop->set_delay(-9.5e-3);  // its clock is ahead
  run(kTick);
  EXPECT_DOUBLE_EQ(listener.damping_max, 5.0);
}

TEST_F(ServoTickTest, NoReadingIsInventedForADeviceThatIsLateToStart) {
  device.silent = true;
  device.pose.position = {1.0, 2.0, 3.0};
  begin();
  EXPECT_EQ(run(1.0).fault, Fault::kStalePose);
  device.silent = false;
  EXPECT_EQ(run(1.0).fault, Fault::kNone);  // no jump from the origin
  EXPECT_EQ(run(0.5).state, GovernorState::kActive);
}

TEST_F(ServoTickTest, AnotherModelComesThroughTheGate) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  run(0.05);
  Wall other(200.0);
  loop->use({&other, &contacts});
  run(2.0);
  EXPECT_EQ(device.shown.force.x(), 0.0);  // the tool is still in the wall
  EXPECT_EQ(loop->governor().state(), GovernorState::kWaiting);
  go_to(0.01);
  EXPECT_EQ(run(1.0).state, GovernorState::kActive);
  go_to(-0.01);
  run(0.05);
  EXPECT_NEAR(device.shown.force.x(), 2.0, 1e-3);
}

TEST_F(ServoTickTest, AnotherModelDoesNotEndAnEmergencyStop) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  loop->governor().stop();
  run(0.2);
  Wall other(200.0);
  loop->use({&other, &contacts});
  EXPECT_EQ(run(3.0).fault, Fault::kEmergencyStop);
  EXPECT_EQ(loop->governor().state(), GovernorState::kStopped);
}

TEST_F(ServoTickTest, TheClutchMovesTheHandAndNotTheTool) {
  begin();
  device.pose.position.x() = 0.02;
  run(1.0);
  loop->press_clutch(true);
  run(0.3);
  const Vector3d held = run(kTick).tool.position;
  go_to(0.10);
  EXPECT_NEAR((run(kTick).tool.position - held).norm(), 0.0, 1e-5);
  EXPECT_EQ(device.shown.force, Vector3d(Vector3d::Zero()));
  loop->press_clutch(false);
  run(1.5);
  EXPECT_EQ(loop->governor().state(), GovernorState::kActive);
  go_to(0.08);  // 20 mm back: the tool is at 0 again
  EXPECT_NEAR(run(kTick).tool.position.x(), 0.0, 1e-5);
  go_to(0.07);
  run(0.05);
  EXPECT_NEAR(device.shown.force.x(), 5.0, 0.02);
}

// A hand that turns while the clutch is pressed takes hold anew: the tool keeps its orientation, and turns
// from there on as the hand does. The map that says so is in the record.
TEST_F(ServoTickTest, TheClutchTurnsTheHandAndNotTheTool) {
  ServoTickOptions options;
  options.map.rotation = Eigen::AngleAxisd(0.7, Vector3d::UnitY());
  begin(options);
  const auto turn_to = [&](double angle) {
    const Eigen::Quaterniond from = device.pose.orientation;
    const Eigen::Quaterniond there(Eigen::AngleAxisd(angle, Vector3d(1, 2, 2) / 3.0));
    for (int k = 1; k <= 50; ++k) {
      device.pose.orientation = from.slerp(k / 50.0, there);
      run(kTick);
    }
  };
  device.pose.position.x() = 0.02;
  run(1.0);
  loop->press_clutch(true);
  run(0.3);
  const Pose held = run(kTick).tool;
  const WorkspaceMap before = loop->map();
  turn_to(1.0);
  const TickRecord& pressed = run(kTick);
  EXPECT_LT(pressed.tool.orientation.angularDistance(held.orientation), 1e-12);
  EXPECT_EQ(pressed.tool.position, held.position);
  EXPECT_EQ(pressed.velocity.angular, Vector3d(Vector3d::Zero()));
  EXPECT_EQ(pressed.map.offset, before.offset) << "while it is pressed, who maps poses keeps its map";
  loop->press_clutch(false);
  EXPECT_LT(run(1.0).tool.orientation.angularDistance(held.orientation), 1e-9);
  turn_to(1.5);
  const TickRecord& turned = run(kTick);
  const Eigen::Quaterniond by = options.map.rotation *
                                Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 2) / 3.0)) *
                                options.map.rotation.conjugate();
  EXPECT_LT(turned.tool.orientation.angularDistance(by * held.orientation), 1e-9);
  const Pose again = turned.map.to_world(turned.reading.pose);
  EXPECT_TRUE(again.position.isApprox(turned.tool.position, 1e-12));
  EXPECT_LT(again.orientation.angularDistance(turned.tool.orientation), 1e-9);
}

TEST_F(ServoTickTest, BringsTheToolElsewhereAndLeavesTheHand) {
  begin();
  device.pose.position.x() = 0.02;
  run(1.0);
  go_to(-0.01);
  const auto from_hand = [](const TickRecord& now) {
    return Vector3d(now.tool.position - now.reading.pose.position);
  };
  Pose place;
  place.position = {0.5, 0.0, 700.0};
  loop->bring(place, 1e3);
  EXPECT_EQ(from_hand(run(0.3)).norm(), 0.0) << "it is within reach of it";
  EXPECT_EQ(loop->governor().state(), GovernorState::kActive);
  EXPECT_NE(device.shown.force.norm(), 0.0);
  loop->bring(place, 1.0);
  for (run(kTick); device.shown.force.norm() > 0.0; run(kTick))
    ASSERT_EQ(from_hand(run(kTick)).norm(), 0.0) << "as long as there is a force";
  const TickRecord& there = run(0.01);
  EXPECT_NEAR((there.tool.position - place.position).norm(), 0.0, 1e-4);
  EXPECT_TRUE(there.map.to_world(there.reading.pose).position.isApprox(there.tool.position, 1e-12));
  const double x = there.tool.position.x();
  go_to(0.0);
  EXPECT_NEAR(run(kTick).tool.position.x() - x, 0.01, 1e-4);
}

TEST_F(ServoTickTest, AMapScalesTheWayAndNotTheStiffness) {
  ServoTickOptions options;
  options.map.scale = 4.0;
  options.map.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ());
  options.map.offset = {0.04, 0, 0};
  begin(options);  // x_world = 0.04 - 4 y_device
  run(1.0);
  for (int k = 1; k <= 40; ++k) {
    device.pose.position.y() = 5e-4 * k;
    run(kTick);
  }
  const TickRecord& now = run(0.05);
  EXPECT_NEAR(now.tool.position.x(), -0.04, 1e-4);
  EXPECT_NEAR(device.shown.force.y(), -500.0 * 0.01, 0.01);  // 10 mm of the hand's way in
  EXPECT_NEAR(now.sent_world.force.x(), 5.0, 0.01);          // along the world's axes
}

TEST_F(ServoTickTest, ADeviceThatIsSilentIsNotHeld) {
  begin();
  device.pose.position.x() = 0.01;
  run(1.0);
  go_to(-0.01);
  run(0.05);
  device.silent = true;
  EXPECT_EQ(run(0.1).fault, Fault::kStalePose);
  EXPECT_EQ(device.shown.force, Vector3d(Vector3d::Zero()));
}

TEST_F(ServoTickTest, ContactsAreThoseOfTheToolWhateverTheModelWants) {
  begin();
  device.pose.position = {0.15, 0, 0};  // on the sphere
  run(0.1);
  ContactSet fresh;
  query(index, Tool{}, loop->count_contacts().tool, fresh);
  EXPECT_GT(fresh.contacts.size(), 0U);
  EXPECT_EQ(loop->count_contacts().contacts, fresh.contacts.size());
  EXPECT_NEAR(loop->count_contacts().k_max, fresh.k_max(), 1e-9);
}

// The scene goes away in between, so that another search would find nothing.
TEST_F(ServoTickTest, ContactsThatAModelWasToldAreNotLookedForAgain) {
  FieldForce field(Tool{});
  loop = std::make_unique<ServoTick>(device, FeltModel{&field, &contacts});
  device.pose.position = {0.15, 0, 0};  // on the sphere
  const SceneIndex there = index;
  const SceneIndex gone = index.registered({1.0, Eigen::Quaterniond::Identity(), {9, 9, 9}});
  run(0.1);
  ContactSet fresh;
  query(there, Tool{}, loop->count_contacts().tool, fresh);
  ASSERT_GT(fresh.contacts.size(), 0U);
  index = gone;
  EXPECT_EQ(loop->count_contacts().contacts, fresh.contacts.size());
  EXPECT_EQ(run(kTick).felt.wrench.force, Vector3d(Vector3d::Zero()));
  EXPECT_EQ(loop->count_contacts().contacts, 0U) << "and in the next tick they are those of the next tick";
}

// A sphere of 0.15 m comes at 1 m/s until the tool is 15 mm deep in it.
TEST_F(ServoTickTest, AThingThatComesToAStillToolIsFeltWithinTheLimitsOfTheDevice) {
  ProxyForce proxy(index, Tool{Vector3d::Constant(0.02)}, {.stiffness = 1000.0});
  loop = std::make_unique<ServoTick>(device, FeltModel{&proxy, &contacts});
  const SafetyLimits limits = SafetyLimits::of(device.can, kTick);
  device.pose.position = {0.3, 0, 0};
  ASSERT_EQ(run(1.0).state, GovernorState::kActive);
  Vector3d before = device.shown.force;
  for (int k = 0; k < 145; ++k) {
    index = index.registered({1.0, Eigen::Quaterniond::Identity(), {1e-3 * k, 0, 0}});
    const TickRecord& record = run(kTick);
    EXPECT_EQ(record.fault, Fault::kNone);
    EXPECT_LE(device.shown.force.norm(), limits.force_max * (1.0 + 1e-9));
    EXPECT_LE((device.shown.force - before).norm(), 2.0 * kTick * limits.force_slew * (1.0 + 1e-9)) << k;
    EXPECT_GE(device.shown.force.x(), 0.0) << "out of it, at " << k;
    before = device.shown.force;
  }
  EXPECT_GT(device.shown.force.x(), 5.0);
}

TEST_F(ServoTickTest, LooksAtTheContactsOfTheTool) {
  begin();
  device.pose.position = {0.14, 0, 0};
  const TickRecord& record = run(kTick);
  ContactSet found;
  ToolTracker(index, Tool{}).query(record.tool, found, ToolTracker::kMost);
  ASSERT_GT(found.contacts.size(), 0U);
  ASSERT_GT(found.filtered, found.contacts.size());
  ASSERT_GT(found.candidates, found.filtered);
  loop->count_contacts();
  EXPECT_EQ(record.contacts, found.contacts.size());
  EXPECT_EQ(record.filtered, found.filtered);
  EXPECT_EQ(record.candidates, found.candidates);
  EXPECT_EQ(record.k_max, found.k_max());
}

// Ten thousand splats in a tool, for a model that wants them all: no force, a reason, and no memory taken.
TEST_F(ServoTickTest, MoreContactsThanATickHasTimeForAreAFault) {
  ProceduralOptions dense;
  dense.spacing = 0.0015;
  const SceneIndex crowd(make_scene(*make_surface("sphere"), dense), {}, {});
  const Tool large(Vector3d::Constant(0.2));
  ToolTracker many(crowd, large);
  ContactSet all;
  query(crowd, large, Pose{{0.05, 0, 0}, Eigen::Quaterniond::Identity()}, all);
  ASSERT_GT(all.contacts.size(), 2 * ToolTracker::kMost);
  FieldForce field(large);
  loop = std::make_unique<ServoTick>(device, FeltModel{&field, &many});
  device.pose.position = {0.05, 0, 0};
  const test::AllocationGuard guard;
  EXPECT_EQ(run(0.2).fault, Fault::kCrowded);
  loop->count_contacts();
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(device.shown.force, Vector3d(Vector3d::Zero()));
  loop->use({&wall, &many});  // one that does not want them looks on, as far as there is time
  EXPECT_EQ(run(1.0).fault, Fault::kNone);
  EXPECT_LE(loop->count_contacts().contacts, ToolTracker::kRoom);
  EXPECT_GT(loop->count_contacts().contacts, 1000U);
}

TEST_F(ServoTickTest, TakesNothingFromTheHeap) {
  begin();
  device.pose.position = {0.14, 0, 0};
  run(1.0);
  Wall other(200.0);
  const test::AllocationGuard guard;
  loop->use({&other, &contacts});
  loop->set_gain(2.0);
  for (int k = 0; k < 1000; ++k) {
    run(kTick);
    loop->count_contacts();
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
