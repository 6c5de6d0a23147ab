/// \file
/// Conformance tests of the HapticDevice contract, for every driver. Needs GoogleTest. To be included by one
/// source of a program, which says what to test:
///
///     #include <palpate/device/testing/device_contract.h>
///     using namespace palpate::test;
///     INSTANTIATE_TEST_SUITE_P(MyDriver, HapticDeviceContract, testing::Values(DeviceUnderTest{
///         "arm", [] { return std::make_unique<ArmDevice>("/dev/arm0"); }, {.real_time = true}}));
///
/// It writes no force but to devices that tell what they show. Nobody has to hold the handle.
#pragma once

#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <palpate/servo/haptic_device.h>

namespace palpate::test {

/// What a driver's author may tell besides how to make a device.
struct DeviceTestOptions {
  /// A device of hardware or of a network: ticks are a millisecond of real time apart. Else time is virtual.
  bool real_time = false;
  /// Called before each read() at `t`: whoever feeds the device does it here. Empty: nobody has to.
  std::function<void(double t)> feed = {};
  /// What its motors show; empty: that cannot be told.
  std::function<Wrench(const HapticDevice&)> shown = {};
  /// How often this thread has taken memory from the heap so far; null: that is not counted.
  std::size_t (*allocations)() = nullptr;
};

struct DeviceUnderTest {
  std::string name;
  std::function<std::unique_ptr<HapticDevice>()> make;
  DeviceTestOptions options = {};
};

inline void PrintTo(const DeviceUnderTest& device, std::ostream* out) { *out << device.name; }

class HapticDeviceContract : public ::testing::TestWithParam<DeviceUnderTest> {
 protected:
  void SetUp() override { device_ = GetParam().make(); }

  const DeviceTestOptions& options() const { return GetParam().options; }

  void open_and_enable() {
    open_device(*device_, {});
    device_->enable();
    ASSERT_EQ(device_->status(), DeviceStatus::kEnabled) << device_->status_text();
    if (!t_begun_) clock_ = LoopClock();
    t_begun_ = true;
  }

  /// The beginning of a tick. \returns whether there was a reading.
  bool tick() {
    if (options().real_time) clock_.sleep_until(clock_.now() + kTick);
    t_ = options().real_time ? clock_.now() : t_ + kTick;
    if (options().feed) options().feed(t_);
    return device_->read(t_, reading_);
  }

  /// Writes `wrench` for a while that is longer than any device takes to show it.
  void show(const Wrench& wrench) {
    for (int k = 0; k < kTicks / 4; ++k) {
      tick();
      device_->write(wrench);
    }
    tick();
  }
  /// Little, but enough to be seen.
  Wrench small_force() const {
    Wrench wrench;
    wrench.force.z() = 0.05 * device_->capabilities().force_max;
    return wrench;
  }
  double shown() const {
    const Wrench wrench = options().shown(*device_);
    return wrench.force.norm() + wrench.torque.norm();
  }

  static constexpr double kTick = 1e-3;  ///< Unit: [s].
  static constexpr int kTicks = 400;
  /// Of a clock of a device that has been compared with the loop's. Unit: [s].
  static constexpr double kClock = 1e-4;

  std::unique_ptr<HapticDevice> device_;
  DeviceReading reading_;
  LoopClock clock_;
  bool t_begun_ = false;
  double t_ = 0.0;
};

TEST_P(HapticDeviceContract, GoesThroughItsLifeTwice) {
  for (int life = 0; life < 2; ++life) {
    open_device(*device_, {});
    EXPECT_EQ(device_->status(), DeviceStatus::kOpen);
    device_->enable();
    EXPECT_EQ(device_->status(), DeviceStatus::kEnabled) << device_->status_text();
    device_->close();
    EXPECT_EQ(device_->status(), DeviceStatus::kClosed);
    device_->close();
    EXPECT_EQ(device_->status(), DeviceStatus::kClosed);
  }
}

TEST_P(HapticDeviceContract, SaysTheSameOfItselfForAsLongAsItIsOpen) {
  open_and_enable();
  const DeviceCapabilities before = device_->capabilities();
  EXPECT_NO_THROW(check_capabilities(before));
  EXPECT_FALSE(before.name.empty());
  for (int k = 0; k < kTicks; ++k) tick();
  const DeviceCapabilities& after = device_->capabilities();
  EXPECT_EQ(after.name, before.name);
  EXPECT_EQ(after.force_max, before.force_max);
  EXPECT_EQ(after.torque_max, before.torque_max);
  EXPECT_EQ(after.damping, before.damping);
  EXPECT_EQ(after.angular_damping, before.angular_damping);
  EXPECT_EQ(after.rate, before.rate);
}

TEST_P(HapticDeviceContract, ReadsWhatIsAPoseAtATimeThatHasCome) {
  open_and_enable();
  int readings = 0;
  DeviceReading last;
  for (int k = 0; k < kTicks; ++k) {
    if (!tick()) continue;
    ASSERT_TRUE(std::isfinite(reading_.t) && reading_.pose.position.allFinite());
    ASSERT_TRUE(reading_.velocity.linear.allFinite() && reading_.velocity.angular.allFinite());
    ASSERT_NEAR(reading_.pose.orientation.norm(), 1.0, 1e-3);
    ASSERT_LE(reading_.t, t_ + kClock) << "the reading is in the future";
    if (readings > 0) {
      ASSERT_GE(reading_.t, last.t);
    }
    if (readings > 0 && device_->capabilities().sensed.rotation == 0) {
      ASSERT_LT(reading_.pose.orientation.angularDistance(last.pose.orientation), 1e-9)
          << "the device senses no rotation";
    }
    last = reading_;
    ++readings;
  }
  EXPECT_GT(readings, 0);
}

TEST_P(HapticDeviceContract, LeavesTheReadingAloneWhereThereIsNone) {
  open_and_enable();
  constexpr double kMark = -7.0;  // that no clock of a loop tells
  for (int k = 0; k < kTicks; ++k) {
    reading_.t = reading_.pose.position.x() = kMark;
    if (tick()) {
      ASSERT_NE(reading_.t, kMark);
      reading_.t = reading_.pose.position.x() = kMark;
      if (device_->read(t_, reading_)) continue;  // within the same tick
    }
    ASSERT_EQ(reading_.t, kMark);
    ASSERT_EQ(reading_.pose.position.x(), kMark);
  }
}

TEST_P(HapticDeviceContract, TakesNothingFromTheHeapInATick) {
  if (options().allocations == nullptr) GTEST_SKIP() << "no allocation counter";
  open_and_enable();
  for (int k = 0; k < kTicks; ++k) {
    t_ = options().real_time ? clock_.now() : t_ + kTick;
    if (options().feed) options().feed(t_);
    const std::size_t before = options().allocations();
    device_->read(t_, reading_);
    device_->write({});
    device_->stop();
    ASSERT_EQ(options().allocations(), before);
  }
}

TEST_P(HapticDeviceContract, StopTurnsTheMotorsOffUntilTheNextWrite) {
  open_and_enable();
  const Wrench wrench = options().shown ? small_force() : Wrench{};
  for (int k = 0; k < 3; ++k) {
    show(wrench);
    if (options().shown) {
      EXPECT_GT(shown(), 0.0);
    }
    device_->stop();
    device_->stop();
    if (options().shown) {
      EXPECT_EQ(shown(), 0.0);
    }
  }
}

TEST_P(HapticDeviceContract, IsStoppedByAnotherThreadWhileItIsUsed) {
  open_and_enable();
  const Wrench wrench = options().shown ? small_force() : Wrench{};
  std::atomic<bool> ends = false;
  std::thread watchdog([&] {
    while (!ends.load(std::memory_order_relaxed)) {
      device_->stop();
      device_->status();
      std::this_thread::yield();
    }
  });
  for (int k = 0; k < kTicks; ++k) {
    tick();
    device_->write(wrench);
  }
  ends = true;
  watchdog.join();
  device_->stop();
  if (options().shown) {
    EXPECT_EQ(shown(), 0.0);
    show(wrench);
    EXPECT_GT(shown(), 0.0);
  }
}

TEST_P(HapticDeviceContract, MayBeStoppedAtAnyTimeOfItsLife) {
  device_->stop();
  open_device(*device_, {});
  device_->stop();
  device_->enable();
  device_->stop();
  device_->close();
  device_->stop();
  EXPECT_EQ(device_->status(), DeviceStatus::kClosed);
}

TEST_P(HapticDeviceContract, ShowsNothingUnlessItIsEnabled) {
  if (!options().shown) GTEST_SKIP() << "the output cannot be measured";
  open_and_enable();
  EXPECT_EQ(shown(), 0.0) << "output right after enable()";
  show(small_force());
  EXPECT_GT(shown(), 0.0);
  device_->close();
  EXPECT_EQ(shown(), 0.0);
  device_->write(small_force());
  EXPECT_EQ(shown(), 0.0) << "output while closed";
  open_device(*device_, {});
  EXPECT_EQ(shown(), 0.0);
  show(small_force());
  EXPECT_EQ(shown(), 0.0) << "output while open but not enabled";
  device_->enable();
  EXPECT_EQ(shown(), 0.0) << "output of a wrench written before enable()";
}

TEST_P(HapticDeviceContract, MayBeLetGoOfWhileItIsEnabled) {
  open_and_enable();
  tick();
  device_.reset();
}

}  // namespace palpate::test
