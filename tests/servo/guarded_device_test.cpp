#include <palpate/servo/guarded_device.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

/// Throws from the call that it is told.
class Thrower final : public HapticDevice {
 public:
  enum class At { kNowhere, kRead, kWait, kWrite };
  At at = At::kNowhere;
  int calls = 0, stops = 0;

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double, DeviceReading&) override { return call(At::kRead); }
  void wait(const LoopClock&, double) override { call(At::kWait); }
  void write(const Wrench&) override { call(At::kWrite); }
  void stop() noexcept override { ++stops; }
  bool come_to_rest() override {
    ++calls;
    return false;
  }

 private:
  bool call(At here) {
    ++calls;
    if (at == here) throw Error("the cable burns");
    return true;
  }
  DeviceCapabilities capabilities_;
};

class GuardedDeviceTest : public testing::TestWithParam<Thrower::At> {
 protected:
  void tick() {
    device.wait(clock, 0.0);
    DeviceReading reading;
    heard = device.read(0.0, reading);
    device.write({});
  }
  Thrower driver;
  GuardedDevice device{driver};
  LoopClock clock;
  bool heard = false;
};

TEST_P(GuardedDeviceTest, AsksADriverThatThrewNoMore) {
  tick();
  EXPECT_TRUE(heard);
  EXPECT_EQ(driver.calls, 3);
  EXPECT_FALSE(device.come_to_rest());
  EXPECT_EQ(device.thrown(), "");
  driver.at = GetParam();
  tick();
  EXPECT_EQ(device.thrown(), "the cable burns");
  EXPECT_EQ(driver.stops, 1);
  EXPECT_TRUE(device.come_to_rest()) << "a loop does not wait for it";
  const int calls = driver.calls;
  driver.at = Thrower::At::kNowhere;
  tick();
  EXPECT_FALSE(heard);
  EXPECT_EQ(driver.calls, calls);
  device.stop();  // as before
  EXPECT_EQ(driver.stops, 2);
}

INSTANTIATE_TEST_SUITE_P(Calls, GuardedDeviceTest,
                         testing::Values(Thrower::At::kRead, Thrower::At::kWait, Thrower::At::kWrite));

TEST(GuardedDevice, WritesZeroAfterAStop) {
  struct Motors final : HapticDevice {
    const DeviceCapabilities& capabilities() const override { return can; }
    bool read(double, DeviceReading&) override { return false; }
    void write(const Wrench& wrench) override { pull = wrench.force.z(); }
    DeviceCapabilities can;
    double pull = 0.0;
  } driver;
  GuardedDevice device(driver);
  const Wrench pull{{0.0, 0.0, 5.0}, {0.0, 0.0, 0.0}};
  device.write(pull);
  EXPECT_EQ(driver.pull, 5.0);
  device.stop();
  device.write(pull);  // of a tick that had decided before
  EXPECT_EQ(driver.pull, 0.0);
  device.write(pull);
  EXPECT_EQ(driver.pull, 5.0);
}

/// Does not return from read() until it is let.
class Hanger final : public HapticDevice {
 public:
  std::atomic<bool> is_in = false, may_return = false, has_returned = false;

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override {
    is_in = true;
    while (!may_return) sleep_until(monotonic_now() + 1e-3);
    reading.t = t;
    has_returned = true;
    return true;
  }
  void write(const Wrench&) override {}
  void stop() noexcept override { ++stops; }
  std::atomic<int> stops = 0;

 private:
  DeviceCapabilities capabilities_;
};

TEST(GuardedDevice, LeavesTheThreadOfACallThatHangsBehind) {
  static Hanger driver;  // the thread may use it for as long as the program runs
  static std::atomic<bool> came_back = false;
  static DeviceReading reading;
  auto device = std::make_unique<GuardedDevice>(driver);
  EXPECT_FALSE(device->abandon()) << "nothing hangs";
  std::thread([&device = *device] {
    device.read(7.0, reading);
    came_back = true;
  }).detach();
  while (!driver.is_in) sleep_until(monotonic_now() + 1e-3);
  EXPECT_TRUE(device->abandon());
  device.reset();
  driver.may_return = true;
  while (!driver.has_returned) sleep_until(monotonic_now() + 1e-3);
  sleep_until(monotonic_now() + 0.05);
  EXPECT_FALSE(came_back);
  EXPECT_EQ(reading.t, 0.0);
  EXPECT_EQ(driver.stops, 1) << "what it has done at last may have been a write";
}

/// Throws what says nothing.
class Silent final : public HapticDevice {
 public:
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double, DeviceReading&) override { throw 3; }
  void write(const Wrench&) override { throw std::runtime_error(""); }

 private:
  DeviceCapabilities capabilities_;
};

TEST(GuardedDevice, SaysSomethingWhateverIsThrown) {
  Silent driver;
  GuardedDevice device(driver), other(driver);
  DeviceReading reading;
  EXPECT_FALSE(device.read(0.0, reading));
  EXPECT_EQ(device.thrown(), "its driver failed");
  other.write({});
  EXPECT_EQ(other.thrown(), "its driver failed");
}

/// A message that is longer than what is kept of it.
class Talker final : public HapticDevice {
 public:
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double, DeviceReading&) override { throw std::runtime_error(std::string(10000, 'x')); }
  void write(const Wrench&) override {}

 private:
  DeviceCapabilities capabilities_;
};

TEST(GuardedDevice, KeepsTheBeginningOfALongMessage) {
  Talker driver;
  GuardedDevice device(driver);
  DeviceReading reading;
  EXPECT_FALSE(device.read(0.0, reading));
  EXPECT_EQ(device.thrown(), std::string(256, 'x'));
}

}  // namespace
}  // namespace palpate
