#include <palpate/servo/safety_governor.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "support/allocation_guard.h"
#include "support/not_finite.h"
#include "support/tick.h"

namespace palpate {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::kInfinity;
using test::kNan;
using test::kTick;

constexpr double kClockRounding = 1e-7;  // of a clock that tells days, in what is of milliseconds. Unit: [N].

DeviceCapabilities device() {
  DeviceCapabilities d;
  d.force_max = 8.0;
  d.torque_max = 0.4;
  return d;
}

Wrench force(const Vector3d& f) { return {f, Vector3d::Zero()}; }

/// A loop at 1 kHz with a hand that trembles.
class Loop {
 public:
  explicit Loop(const DeviceCapabilities& d = device())
      : limits(SafetyLimits::of(d, kTick)), governor(limits) {}

  /// What happens in a tick, for a test to change.
  struct Tick {
    DeviceReading reading;
    Wrench wanted;
    double contacts_age = 0.0;
    bool answers = true;  ///< there is a new reading
    double late = 0.0;    ///< by which the next one is. Unit: [s].
  };

  Wrench tick(const std::function<void(Tick&)>& change = {}) {
    const double last = t;
    t += period + late;
    ++count;
    Tick now;
    now.reading.t = t;
    now.reading.pose.position = center + 1e-5 * Vector3d(std::sin(0.05 * count), std::cos(0.05 * count), 0.0);
    now.wanted = wanted;
    if (change) change(now);
    late = now.late;
    if (now.answers) said = now.reading;
    governor.admit(said, t);
    const Wrench before = sent;
    sent = governor.release(now.wanted, now.contacts_age);
    EXPECT_LE((sent.force - before.force).norm(), limits.force_slew * (t - last));
    return sent;
  }

  void run(double seconds, const std::function<void(Tick&)>& change = {}) {
    for (int k = 0; k < std::lround(seconds / period); ++k) tick(change);
  }

  /// Until all of `f` is felt.
  void feel(const Vector3d& f) {
    wanted = {};
    run(limits.gate_time + limits.rise_time + 0.01);
    wanted = force(f);
    run(2 * SafetyLimits::kSlewTime);
    ASSERT_EQ(governor.state(), GovernorState::kActive);
    ASSERT_EQ(sent.force, f);
  }

  SafetyLimits limits;
  SafetyGovernor governor;
  Wrench wanted, sent;
  DeviceReading said;
  Vector3d center = Vector3d::Zero();
  double period = kTick, late = 0.0;
  double t = 100.0;  // a clock that did not start with the loop
  int count = 0;
};

TEST(SafetyGovernor, NothingIsFeltUntilWhatIsAskedForIsSmall) {
  Loop loop;
  loop.wanted = force({0, 0, 5});  // the tool begins inside something
  loop.run(3.0);
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
  EXPECT_EQ(loop.sent.force, Vector3d::Zero());
  loop.wanted = force({0, 0, 0.3});
  loop.run(loop.limits.gate_time + 2 * kTick);
  EXPECT_EQ(loop.governor.state(), GovernorState::kRising);
}

// A device of 20 Hz is silent for 100 ms, before its first reading and after a fault, which stale_after
// permits: until a reading is answered, nothing is known of the force that the tool meets where it is.
TEST(SafetyGovernor, NothingIsSmallBeforeItIsAskedFor) {
  DeviceCapabilities slow = device();
  slow.rate = 20.0;
  Loop loop(slow);
  const double silent = 0.1;
  ASSERT_GT(silent, loop.limits.gate_time);
  ASSERT_GT(loop.limits.stale_after, silent);
  const auto waits = [&] {
    EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting) << loop.t;
    loop.run(silent - kTick, [](Loop::Tick& now) { now.answers = false; });
    EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting) << loop.t;
  };
  loop.said.t = loop.t + 1e6;  // no reading
  loop.governor.admit_none(loop.t);
  waits();
  loop.tick();
  loop.run(loop.limits.gate_time + kTick);
  EXPECT_EQ(loop.governor.state(), GovernorState::kRising);
  loop.governor.stop(Fault::kChanging);
  while (loop.governor.state() != GovernorState::kWaiting) loop.tick();
  waits();
}

TEST(SafetyGovernor, TheGateNeedsItSmallAllTheTime) {
  Loop loop;
  for (int k = 0; k < 1000; ++k) {
    loop.wanted = force({0, 0, k % 40 == 0 ? 5.0 : 0.0});
    EXPECT_EQ(loop.tick().force, Vector3d::Zero());
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
}

TEST(SafetyGovernor, ForceRisesEvenly) {
  Loop loop;
  loop.run(loop.limits.gate_time + kTick);
  while (loop.governor.state() == GovernorState::kWaiting) loop.tick();
  loop.wanted = force({4, 0, 0});
  loop.run(loop.limits.rise_time / 2);
  EXPECT_NEAR(loop.sent.force.x(), 2.0, 4.0 * 2 * kTick / loop.limits.rise_time);
  loop.run(loop.limits.rise_time / 2 + kTick);
  EXPECT_EQ(loop.sent.force.x(), 4.0);
}

TEST(SafetyGovernor, ClampsAndKeepsTheDirection) {
  Loop loop;
  loop.feel({1, 0, 0});
  const Vector3d d = Vector3d(1, -2, 2) / 3;
  for (const double size : {8.1, 1e3, 1e300}) {
    loop.wanted = {size * d, size * d};
    loop.run(0.05);
    EXPECT_LT((loop.sent.force - 8.0 * d).norm(), 1e-10) << size;
    EXPECT_LT((loop.sent.torque - 0.4 * d).norm(), 1e-10) << size;
  }
}

TEST(SafetyGovernor, ADeviceWithoutTorqueGetsNone) {
  DeviceCapabilities flat = device();
  flat.torque_max = 0.0;
  Loop loop(flat);
  loop.feel({1, 0, 0});
  loop.wanted.torque = {0, 0, 1};
  loop.run(0.1);
  EXPECT_EQ(loop.governor.state(), GovernorState::kActive);
  EXPECT_EQ(loop.sent.torque, Vector3d::Zero());
}

TEST(SafetyGovernor, ADeviceOfFewReadingsIsStaleAfterThreeOfThem) {
  DeviceCapabilities slow = device();
  EXPECT_EQ(SafetyLimits::of(slow, kTick).stale_after, 0.02);
  slow.rate = 60.0;
  EXPECT_DOUBLE_EQ(SafetyLimits::of(slow, kTick).stale_after, 0.05);
}

TEST(SafetyGovernor, SlewsByHand) {
  Loop loop;
  loop.feel({0, 0, 0.1});
  loop.wanted = force({0, 0, 8});
  EXPECT_NEAR(loop.tick().force.z(), 0.9, 1e-9);  // 8 N in 10 ms
  EXPECT_NEAR(loop.tick().force.z(), 1.7, 1e-9);
}

// A hand that leans on a wall: motors that hold a quarter for ever.
TEST(SafetyGovernor, AForceThatTheMotorsDoNotHoldComesDownToWhatTheyDo) {
  DeviceCapabilities warm = device();
  warm.force_sustained = 2.0;
  warm.torque_sustained = 0.1;
  Loop loop(warm);
  loop.feel({7, 0, 0});
  loop.wanted = {{20, 0, 0}, {0, 1, 0}};
  Wrench before = loop.tick();
  for (int k = 0; k < 60'000; ++k) {
    loop.tick();
    if (k > 50) {
      ASSERT_LE(loop.sent.force.x(), before.force.x() + 1e-12);
    }
    before = loop.sent;
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kActive);
  EXPECT_NEAR(loop.sent.force.x(), 2.0, 0.01);
  EXPECT_NEAR(loop.sent.torque.y(), 0.1, 0.001);
  loop.wanted = force({0.1, 0, 0});
  loop.run(20.0);
  loop.wanted = force({8, 0, 0});
  loop.run(0.02);
  EXPECT_NEAR(loop.sent.force.x(), 8.0, 1e-9) << "it has cooled";
}

/// One way for things to go wrong.
struct Trouble {
  const char* name;
  Fault fault;
  double notice;  ///< until it is one, as documented. Unit: [s].
  std::function<void(Loop&, Loop::Tick&)> change;
};

void PrintTo(const Trouble& trouble, std::ostream* out) { *out << trouble.name; }

class SafetyGovernorOn : public testing::TestWithParam<Trouble> {};

TEST_P(SafetyGovernorOn, BringsTheForceToZeroInItsTimeAndSaysWhy) {
  const auto& [name, fault, notice, change] = GetParam();
  Loop loop;
  loop.feel({3, 0, 4});
  const std::size_t before = loop.governor.transition_count();
  const auto trouble = [&](Loop::Tick& tick) { change(loop, tick); };
  const double start = loop.t;
  while (loop.governor.state() == GovernorState::kActive && loop.t < start + notice + 0.01)
    loop.tick(trouble);
  ASSERT_EQ(loop.governor.state(), GovernorState::kFalling);
  EXPECT_EQ(loop.governor.fault(), fault) << traits(loop.governor.fault()).name;
  EXPECT_LE(loop.t - start, notice + 2 * kTick + 1e-9);
  double last = 5.0;
  for (double t = kTick; t < traits(fault).fall_time; t += kTick) {
    const double now = loop.tick(trouble).force.norm();
    EXPECT_LE(now, last + 1e-12);
    last = now;
  }
  EXPECT_EQ(loop.sent.force, Vector3d::Zero());
  loop.tick(trouble);
  loop.tick(trouble);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
  const auto seen = loop.governor.transitions();
  EXPECT_EQ(loop.governor.transition_count(), before + 2);
  EXPECT_EQ(seen[seen.size() - 2].to, GovernorState::kFalling);
  EXPECT_EQ(seen.back().fault, fault);
}

TEST_P(SafetyGovernorOn, ComesBackThroughTheGateOnceItIsOver) {
  const auto& [name, fault, notice, change] = GetParam();
  Loop loop;
  loop.feel({3, 0, 4});
  loop.run(notice + 0.2, [&](Loop::Tick& tick) { change(loop, tick); });
  ASSERT_EQ(loop.governor.state(), GovernorState::kStopped) << to_string(loop.governor.state());
  loop.run(loop.limits.recover_after + 0.3);  // it asks for 5 N all the time, as inside something
  EXPECT_EQ(loop.sent.force, Vector3d::Zero());
  if (traits(fault).latched) {
    EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
    EXPECT_EQ(loop.governor.fault(), fault);
    loop.governor.resume();
    loop.run(2 * kTick);
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
  EXPECT_EQ(loop.governor.fault(), Fault::kNone);
  loop.feel({3, 0, 4});
}

/// As a hand that has let go.
void throw_tool(Loop& loop, Loop::Tick& tick, double speed) {
  loop.center.y() += speed * kTick;
  tick.reading.pose.position.y() = loop.center.y();
}

INSTANTIATE_TEST_SUITE_P(Everything, SafetyGovernorOn,
                         testing::Values(
                             Trouble{"NanPosition", Fault::kBadPose, 0.0,
                                     [](Loop&, Loop::Tick& t) { t.reading.pose.position.x() = kNan; }},
                             Trouble{
                                 "InfiniteVelocity", Fault::kBadPose, 0.0,
                                 [](Loop&, Loop::Tick& t) { t.reading.velocity.angular.z() = kInfinity; }},
                             Trouble{
                                 "NoRotation", Fault::kBadPose, 0.0,
                                 [](Loop&, Loop::Tick& t) { t.reading.pose.orientation.coeffs().setZero(); }},
                             Trouble{"Silence", Fault::kStalePose, 0.021,
                                     [](Loop&, Loop::Tick& t) { t.answers = false; }},
                             Trouble{"OldReadings", Fault::kStalePose, 0.021,
                                     [](Loop&, Loop::Tick& t) { t.reading.t -= 0.5; }},
                             Trouble{"ReadingsOfTheFuture", Fault::kStalePose, 0.021,
                                     [](Loop&, Loop::Tick& t) { t.reading.t += 1e6; }},
                             Trouble{"Frozen", Fault::kFrozenPose, 7.0,
                                     [](Loop&, Loop::Tick& t) { t.reading.pose.position.setZero(); }},
                             Trouble{"JumpsToAndFro", Fault::kJump, 0.0,
                                     [](Loop& loop, Loop::Tick& t) {
                                       t.reading.pose.position.x() += loop.count % 2 == 0 ? 0.02 : 0.0;
                                     }},
                             Trouble{"TurnsToAndFro", Fault::kJump, 0.001,
                                     [](Loop& loop, Loop::Tick& t) {
                                       if (loop.count % 2 == 0)
                                         t.reading.pose.orientation = Quaterniond(0, 1, 0, 0);
                                     }},
                             Trouble{"Thrown", Fault::kOverSpeed, 0.01,
                                     [](Loop& loop, Loop::Tick& t) { throw_tool(loop, t, 6.0); }},
                             Trouble{"SaysItIsFast", Fault::kOverSpeed, 0.0,
                                     [](Loop&, Loop::Tick& t) { t.reading.velocity.linear.y() = -3.5; }},
                             Trouble{"NanForce", Fault::kBadForce, 0.0,
                                     [](Loop&, Loop::Tick& t) { t.wanted.force.x() = kNan; }},
                             Trouble{"InfiniteTorque", Fault::kBadForce, 0.0,
                                     [](Loop&, Loop::Tick& t) { t.wanted.torque.x() = -kInfinity; }},
                             Trouble{"WorkerStalls", Fault::kLateContacts, 0.0,
                                     [](Loop& loop, Loop::Tick& t) {
                                       t.contacts_age = loop.limits.contacts_after + 0.01;
                                     }},
                             Trouble{"NanAge", Fault::kLateContacts, 0.0,
                                     [](Loop&, Loop::Tick& t) { t.contacts_age = kNan; }},
                             Trouble{"OneReadingInThree", Fault::kSlowDevice, 0.35,
                                     [](Loop& loop, Loop::Tick& t) { t.answers = loop.count % 3 == 0; }},
                             Trouble{"TicksAreLate", Fault::kLateTick, 0.06,
                                     [](Loop&, Loop::Tick& t) { t.late = 18e-3; }},
                             Trouble{"PushesByItself", Fault::kOverEnergy,
                                     0.2,  // 5 N along 10 mm make 0.05 J
                                     [](Loop& loop, Loop::Tick& t) {
                                       loop.center += 1e-4 * Vector3d(0.6, 0, 0.8);
                                       t.reading.pose.position = loop.center;
                                     }},
                             Trouble{"Paused", Fault::kPaused, 0.0,
                                     [](Loop& loop, Loop::Tick&) {
                                       if (loop.governor.fault() == Fault::kNone)
                                         loop.governor.stop(Fault::kPaused);
                                     }},
                             Trouble{"Changing", Fault::kChanging, 0.0,
                                     [](Loop& loop, Loop::Tick&) { loop.governor.stop(Fault::kChanging); }},
                             Trouble{"RecordingFailed", Fault::kRecorder, 0.0,
                                     [](Loop& loop, Loop::Tick&) {
                                       if (loop.governor.fault() == Fault::kNone)
                                         loop.governor.stop(Fault::kRecorder);
                                     }},
                             Trouble{"EmergencyStop", Fault::kEmergencyStop, 0.0,
                                     [](Loop& loop, Loop::Tick&) {
                                       if (loop.governor.fault() == Fault::kNone) loop.governor.stop();
                                     }}),
                         [](const auto& info) { return info.param.name; });

TEST(SafetyGovernor, TheGravestReasonIsKept) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.run(0.01, [](Loop::Tick& t) { t.contacts_age = 1.0; });
  EXPECT_EQ(loop.governor.fault(), Fault::kLateContacts);
  loop.governor.stop();
  loop.run(1.0);
  EXPECT_EQ(loop.governor.fault(), Fault::kEmergencyStop);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
}

TEST(SafetyGovernor, OnlyAResumeEndsAnEmergencyStop) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop(Fault::kPaused);
  loop.governor.stop();
  loop.run(0.5);
  loop.governor.unpause();
  loop.run(1.0);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
  EXPECT_EQ(loop.governor.fault(), Fault::kEmergencyStop);
  loop.governor.resume();
  loop.run(0.3);
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
}

TEST(SafetyGovernor, APauseThatIsTakenBackEndsThroughTheGate) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop(Fault::kPaused);
  loop.run(0.5);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
  loop.governor.unpause();
  loop.run(1.0);
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
  EXPECT_EQ(loop.sent.force, Vector3d::Zero());
  loop.feel({3, 0, 4});
}

TEST(SafetyGovernor, WhatLatchedUnderAPauseOutlivesIt) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop(Fault::kRecorder);
  loop.run(0.2);
  loop.governor.stop(Fault::kPaused);
  loop.run(0.2);
  loop.governor.unpause();
  loop.run(1.0);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
  EXPECT_EQ(loop.governor.fault(), Fault::kRecorder);
}

// The fault that is told is taken back; the one behind it is told then.
TEST(SafetyGovernor, WhatIsLeftOfTwoFaultsIsTold) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop(Fault::kPaused);
  loop.run(0.5);
  loop.governor.unpause();
  loop.tick([](Loop::Tick& t) { t.contacts_age = 1.0; });
  EXPECT_EQ(loop.governor.fault(), Fault::kLateContacts);
}

TEST(SafetyGovernor, WhatIsAskedForAsAnotherIsResumedIsTold) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop();
  loop.run(0.5);
  loop.governor.resume();
  loop.governor.stop(Fault::kPaused);
  loop.tick();
  EXPECT_EQ(loop.governor.fault(), Fault::kPaused);
  loop.governor.unpause();
  loop.tick();
  EXPECT_EQ(loop.governor.fault(), Fault::kPaused) << "until it waits again, that was the last";
}

TEST(SafetyGovernor, AReadingThatIsRefusedIsNotAdmitted) {
  SafetyGovernor governor(SafetyLimits::of(device(), kTick));
  double t = 0.0;
  const auto admits = [&](const std::function<void(DeviceReading&)>& change) {
    DeviceReading reading;
    reading.t = t += kTick;
    change(reading);
    const bool admitted = governor.admit(reading, t);
    governor.release({}, 0.0);
    return admitted;
  };
  EXPECT_TRUE(admits([](DeviceReading&) {}));
  EXPECT_FALSE(admits([](DeviceReading& r) { r.pose.position.x() = kNan; }));
  EXPECT_TRUE(admits([](DeviceReading&) {}));
  EXPECT_FALSE(admits([](DeviceReading& r) { r.pose.position.x() = 1.0; })) << "a jump";
  EXPECT_EQ(governor.reading().pose.position.x(), 0.0);
  EXPECT_FALSE(admits([](DeviceReading& r) {
    r.pose.position.x() = 1.0;
    r.velocity.linear.x() = 30.0;
  }));
  EXPECT_FALSE(admits([](DeviceReading& r) { r.t -= 1.0; })) << "an old one";
}

TEST(SafetyGovernor, WhatIsKnownOfADeviceIsWhatIsAllowed) {
  DeviceCapabilities d = device();
  d.workspace = 0.1;
  d.rate = 500.0;
  d.force_sustained = 2.0;
  d.torque_sustained = 0.1;
  const SafetyLimits limits = SafetyLimits::of(d, kTick);
  EXPECT_EQ(limits.force_max, 8.0);
  EXPECT_EQ(limits.torque_max, 0.4);
  EXPECT_EQ(limits.force_sustained, 2.0);
  EXPECT_EQ(limits.torque_sustained, 0.1);
  EXPECT_DOUBLE_EQ(limits.force_slew, 8.0 / SafetyLimits::kSlewTime);
  EXPECT_DOUBLE_EQ(limits.torque_slew, 0.4 / SafetyLimits::kSlewTime);
  EXPECT_DOUBLE_EQ(limits.energy_reserve, 8.0 * 2.0 * 0.2) << "to and fro across the workspace";
  EXPECT_DOUBLE_EQ(limits.reading_period, 2e-3);
  EXPECT_DOUBLE_EQ(SafetyLimits::of(d, 0.05).late_max, 0.15);
}

TEST(SafetyGovernor, SaysWhatShareItLetsThrough) {
  DeviceCapabilities d = device();
  d.force_sustained = 2.0;
  Loop loop(d);
  loop.tick();
  EXPECT_EQ(loop.governor.force_scale(), 0.0) << "the gate is shut";
  loop.feel({0, 0, 0});
  EXPECT_EQ(loop.governor.force_scale(), 1.0) << "all of nothing";
  loop.wanted = force({0, 0, 1.5});
  loop.run(0.1);
  EXPECT_EQ(loop.governor.force_scale(), 1.0);
  loop.wanted = force({0, 0, 6.0});
  loop.run(60.0);
  EXPECT_NEAR(loop.governor.force_scale(), loop.sent.force.norm() / 6.0, 1e-6);
  EXPECT_LT(loop.governor.force_scale(), 0.5);
  loop.governor.stop();
  loop.tick();
  EXPECT_EQ(loop.governor.force_scale(), 0.0);
}

// What has come out is paid for with that fault: it is not told again for the same energy.
TEST(SafetyGovernor, EnergyIsReproachedOnce) {
  Loop loop;
  loop.feel({3, 0, 4});
  const auto pushes = [&](Loop::Tick& t) {
    loop.center += 1e-4 * Vector3d(0.6, 0, 0.8);
    t.reading.pose.position = loop.center;
  };
  for (int k = 0; k < 200 && loop.governor.fault() == Fault::kNone; ++k) loop.tick(pushes);
  ASSERT_EQ(loop.governor.fault(), Fault::kOverEnergy);
  EXPECT_LT(loop.governor.energy(), loop.limits.energy_max);
  loop.wanted = {};
  loop.governor.resume();
  loop.run(loop.limits.recover_after + 2 * kTick);
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
}

// A driver whose clients send at 4 kHz makes ticks of a quarter of a millisecond.
TEST(SafetyGovernor, SlewIsOfTheTimeThatHasPassed) {
  for (const double period : {0.25e-3, 1e-3, 1.5e-3}) {
    Loop loop;
    loop.feel({0, 0, 0.1});
    loop.period = period;
    loop.wanted = force({0, 0, 8});
    const double begin = loop.t;
    loop.run(6e-3);
    EXPECT_NEAR(loop.sent.force.z(), 0.1 + (loop.t - begin) * 800.0, 1e-6) << period;
  }
}

TEST(SafetyGovernor, OneTickThatIsLateMakesNoStep) {
  Loop loop;
  loop.feel({0, 0, 0.1});
  loop.wanted = force({0, 0, 8});
  loop.period = 15e-3;
  const Wrench before = loop.sent;
  loop.tick();
  EXPECT_NEAR((loop.sent.force - before.force).norm(), 800.0 * 2 * kTick, 1e-6);
  EXPECT_EQ(loop.governor.fault(), Fault::kNone);
}

// Stopped by a debugger, say, for a third of a second.
TEST(SafetyGovernor, AGapInTimeEndsInTheGate) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.wanted = force({0, 0, 8});
  loop.t += 0.3;
  loop.tick();
  EXPECT_EQ(loop.governor.fault(), Fault::kLateTick);
  for (int k = 0; k < 30; ++k) {
    const double before = loop.sent.force.norm();
    EXPECT_LT(loop.tick().force.norm(), before + 1e-12);
  }
  loop.run(2.0);
  EXPECT_EQ(loop.sent.force, Vector3d::Zero());
  EXPECT_EQ(loop.governor.state(), GovernorState::kWaiting);
}

TEST(SafetyGovernor, TicksThatAreLateNowAndThenAreForgiven) {
  Loop loop;
  loop.feel({3, 0, 4});
  for (int k = 0; k < 50; ++k) {
    loop.run(0.1);
    loop.t += 9e-3;
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kActive);
  loop.period = 19e-3;
  loop.run(0.06);
  EXPECT_EQ(loop.governor.fault(), Fault::kLateTick);
}

TEST(SafetyGovernor, AQuickTurnOfASlowTrackerIsNoJump) {
  DeviceCapabilities slow = device();
  slow.rate = 60.0;
  Loop loop(slow);
  loop.period = 1.0 / 60.0;
  loop.limits = SafetyLimits::of(slow, loop.period);
  SafetyGovernor governor(loop.limits);
  double t = 0.0, angle = 0.0;
  const auto turn = [&](double speed) {
    t += loop.period;
    angle += speed * loop.period;
    DeviceReading reading{t, {}, {}};
    reading.pose.orientation = Eigen::AngleAxisd(angle, Vector3d::UnitX());
    governor.admit(reading, t);
    governor.release({}, 0.0);
    return governor.fault();
  };
  for (int k = 0; k < 60; ++k) EXPECT_EQ(turn(36.0), Fault::kNone);  // 0.6 rad a reading
  EXPECT_EQ(turn(60.0), Fault::kOverSpeed);                          // by its poses: it tells no velocity
  for (int k = 0; k < 60; ++k) turn(0.0);
  EXPECT_EQ(turn(180.0), Fault::kJump);
}

// Ten thousand readings a second do not permit ten thousand times the noise.
TEST(SafetyGovernor, ManyReadingsPermitNoMoreSpeed) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.period = 1e-4;
  const double begin = loop.t;
  while (loop.governor.fault() == Fault::kNone && loop.t < begin + 0.1)
    loop.tick([&](Loop::Tick& t) {
      loop.center.y() += 4.0 * loop.period;
      t.reading.pose.position.y() = loop.center.y();
    });
  EXPECT_EQ(loop.governor.fault(), Fault::kOverSpeed);
}

TEST(SafetyGovernor, ADeviceThatHasSaidNothingIsAwaited) {
  SafetyGovernor governor(SafetyLimits::of(device(), kTick));
  double t = 5.0;
  const auto silent = [&](double seconds) {
    for (double end = t + seconds; t < end; t += kTick) {
      governor.admit_none(t);
      EXPECT_EQ(governor.release(force({0, 0, 5}), 0.0).force, Vector3d::Zero());
    }
  };
  silent(0.01);
  EXPECT_EQ(governor.fault(), Fault::kNone);
  silent(1.0);
  EXPECT_EQ(governor.fault(), Fault::kStalePose);
  DeviceReading reading;  // far from the origin: no jump, since there was nothing before it
  reading.pose.position = {1, 2, 3};
  for (int k = 0; k < 500; ++k, t += kTick) {
    reading.t = t;
    EXPECT_EQ(governor.admit(reading, t), true);
    governor.release({}, 0.0);
  }
  EXPECT_EQ(governor.fault(), Fault::kNone);
}

TEST(SafetyGovernor, AnEmergencyStopOutranksAPause) {
  Loop loop;
  loop.feel({3, 0, 4});
  loop.governor.stop(Fault::kPaused);
  loop.run(0.5);
  EXPECT_EQ(loop.governor.fault(), Fault::kPaused);
  loop.governor.stop();
  loop.run(0.5);
  EXPECT_EQ(loop.governor.fault(), Fault::kEmergencyStop);
  loop.governor.stop(Fault::kPaused);
  loop.run(0.5);
  EXPECT_EQ(loop.governor.fault(), Fault::kEmergencyStop);
}

// Two threads, one tick: who resumes did not see that someone pressed the button.
TEST(SafetyGovernor, AResumeInTheSameTickDoesNotUndoAnEmergencyStop) {
  for (const bool stop_first : {true, false}) {
    Loop loop;
    loop.feel({3, 0, 4});
    if (!stop_first) loop.governor.resume();
    loop.governor.stop();
    if (stop_first) loop.governor.resume();
    loop.run(3.0);
    EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
    EXPECT_EQ(loop.governor.fault(), Fault::kEmergencyStop);
  }
}

TEST(SafetyGovernor, ResumingIsNoUseWhileTheCauseIsThere) {
  Loop loop;
  loop.feel({3, 0, 4});
  const auto broken = [](Loop::Tick& t) { t.wanted.force.x() = kNan; };
  loop.run(0.1, broken);
  loop.governor.resume();
  loop.run(1.0, broken);
  EXPECT_EQ(loop.governor.state(), GovernorState::kStopped);
}

TEST(SafetyGovernor, ASpringThatIsPressedAndLetGoIsNoFault) {
  Loop loop;
  loop.feel({0, 0, 0});
  for (int k = 0; k < 20'000; ++k) {  // 8 N at 16 mm, 60 mJ there and back, at up to 0.2 m/s
    loop.center.z() = -0.008 * (1.0 - std::cos(0.0125 * k * 2));
    loop.wanted = force({0, 0, -500.0 * loop.center.z()});
    loop.tick();
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kActive) << traits(loop.governor.fault()).name;
  EXPECT_LT(loop.governor.energy(), 0.01);
}

// Seconds are seconds, also of a device that answers in one tick of sixteen.
TEST(SafetyGovernor, ASlowDeviceThatIsFrozenFadesAsSoon) {
  DeviceCapabilities slow = device();
  slow.rate = 60.0;
  Loop loop(slow);
  const auto still = [&](Loop::Tick& t) {
    t.answers = loop.count % 16 == 0;
    t.reading.pose.position.setZero();
  };
  loop.run(1.0, still);
  loop.wanted = force({0, 0, 5});
  loop.run(4.9, still);
  EXPECT_EQ(loop.sent.force.z(), 5.0);
  loop.run(1.1, still);
  EXPECT_NEAR(loop.sent.force.z(), 2.5, 0.1);
  loop.run(1.1, still);
  EXPECT_EQ(loop.sent.force.z(), 0.0);
  EXPECT_EQ(loop.governor.fault(), Fault::kFrozenPose);
}

// Good encoders and a hand that dry friction holds: every count is the same until the force gives way.
TEST(SafetyGovernor, AHandleThatFrictionHoldsIsNotFrozen) {
  Loop loop;
  loop.feel({0, 0, 5});
  double count = 0.0, least = 5.0;
  for (int k = 0; k < 30'000; ++k) {
    loop.tick([&](Loop::Tick& t) {
      if (loop.sent.force.z() < 4.4) count = 1.0 - count;  // 0.6 N of friction, there and back
      t.reading.pose.position = {0, 0, 55e-6 * count};
    });
    least = std::min(least, loop.sent.force.z());
  }
  EXPECT_EQ(loop.governor.state(), GovernorState::kActive) << traits(loop.governor.fault()).name;
  EXPECT_NEAR(least, 4.4, 0.02);
  loop.run(1.0);
  EXPECT_EQ(loop.sent.force.z(), 5.0);
}

// All of the force over 12 cm are 0.96 J, which the hand gets back.
TEST(SafetyGovernor, AHandThatPushesPastTheLargestForceGetsItBack) {
  DeviceCapabilities large = device();
  large.workspace = 0.03;
  Loop loop(large);
  loop.feel({0, 0, 0});
  for (int k = 0; k < 2000; ++k) {
    loop.center.z() = -0.06 * (1.0 - std::cos(0.01 * k));
    loop.wanted = force({0, 0, -500.0 * loop.center.z()});
    loop.tick();
  }
  EXPECT_EQ(loop.governor.fault(), Fault::kNone) << traits(loop.governor.fault()).name;
}

/// Anything that a broken driver, model or worker may say.
class Hostile {
 public:
  explicit Hostile(std::uint32_t seed) : random_(seed) {}

  double number() {
    switch (random_() % 12) {
      case 0: return kNan;
      case 1: return kInfinity;
      case 2: return -std::numeric_limits<double>::max();
      case 3: return std::numeric_limits<double>::denorm_min();
      case 4: {
        const double some = normal_(random_);
        return std::ldexp(some, static_cast<int>(random_() % 600) - 300);
      }
      default: return normal_(random_);
    }
  }
  Vector3d vector() { return {number(), number(), number()}; }
  /// Mostly what a good one says, so that all states are met.
  bool evil() { return random_() % 997 < evil_; }
  void turn() {
    if (random_() % 2000 == 0) evil_ = random_() % 3 == 0 ? random_() % 400 : 0;
  }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0.0, 3.0};
  std::uint32_t evil_ = 0;
};

/// `./test --long` sets PALPATE_LONG: then it is a hundred million.
std::size_t hostile_ticks() { return std::getenv("PALPATE_LONG") != nullptr ? 100'000'000 : 1'000'000; }

TEST(SafetyGovernor, HoldsItsBoundsWhateverGoesIn) {
  const SafetyLimits limits = SafetyLimits::of(device(), kTick);
  SafetyGovernor governor(limits);
  Hostile hostile(20);
  Wrench before;
  std::array<std::size_t, 5> visits{};
  std::size_t broken = 0;
  double t = 0.0;
  const test::AllocationGuard guard;
  for (std::size_t k = 0; k < hostile_ticks(); ++k) {
    hostile.turn();
    const double last = t;
    t += !hostile.evil() ? kTick : hostile.below(2) == 0 ? 0.03 : 1e-4;
    const double passed = t - last;
    DeviceReading reading{t, {}, {}};
    reading.pose.position = 1e-3 * Vector3d(std::sin(0.01 * static_cast<double>(k)), 0, 0);
    Wrench wanted = force({0, 0, k / 300 % 3 == 2 ? 9.0 : 0.1});
    double age = 0.0;
    if (hostile.evil()) reading.t = hostile.number();
    if (hostile.evil()) reading.pose.position = hostile.vector();
    if (hostile.evil()) reading.pose.orientation.coeffs()[2] = hostile.number();
    if (hostile.evil()) reading.velocity = {hostile.vector(), hostile.vector()};
    if (hostile.evil()) wanted = {hostile.vector(), hostile.vector()};
    if (hostile.evil()) age = hostile.number();
    const auto stopped =
        hostile.evil() ? static_cast<Fault>(1 + hostile.below(kFaultCount - 1)) : Fault::kNone;
    if (stopped != Fault::kNone) governor.stop(stopped);
    if (hostile.below(500) == 0) governor.resume();
    if (hostile.below(500) == 0) governor.unpause();
    hostile.below(1000) == 0 ? governor.admit_none(t) : void(governor.admit(reading, t));
    const Wrench sent = governor.release(wanted, age);
    const GovernorState state = governor.state();
    const bool off = state == GovernorState::kWaiting || state == GovernorState::kStopped;
    // A fall is no steeper than all the force in the shortest time of a fault, a tick ahead.
    const double time = state == GovernorState::kFalling ? (passed + kTick) * SafetyLimits::kSlewTime / 0.03
                                                         : std::min(passed, 2.0 * kTick);
    const bool cut = stopped == Fault::kStalled && sent.force.isZero(0.0) && sent.torque.isZero(0.0);
    const bool slewed = (sent.force - before.force).norm() <= limits.force_slew * time + kClockRounding &&
                        (sent.torque - before.torque).norm() <= limits.torque_slew * time + kClockRounding;
    const bool held =
        sent.force.norm() <= limits.force_max && sent.torque.norm() <= limits.torque_max && (slewed || cut);
    const bool falls = state != GovernorState::kFalling || (sent.force.norm() <= before.force.norm() &&
                                                            sent.torque.norm() <= before.torque.norm());
    const bool calm = falls && (!off || (sent.force.isZero(0.0) && sent.torque.isZero(0.0)));
    broken += held && calm && governor.reading().pose.position.allFinite() ? 0 : 1;  // NaN compares false
    ++visits[static_cast<std::size_t>(state)];
    before = sent;
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(broken, 0U);
  for (std::size_t state = 0; state < visits.size(); ++state) {
    EXPECT_GT(visits[state], hostile_ticks() / 1000) << to_string(static_cast<GovernorState>(state));
  }
}

}  // namespace
}  // namespace palpate
