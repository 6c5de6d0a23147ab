#include <palpate/servo/device_capabilities.h>

#include <atomic>
#include <functional>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/servo/haptic_device.h>

#include <support/temporary_file.h>

namespace palpate {
namespace {

DeviceCapabilities good() {
  DeviceCapabilities d;
  d.name = "arm";
  d.force_max = 8.0;
  d.force_sustained = 2.0;
  return d;
}

TEST(DeviceCapabilities, ThatContradictThemselvesAreRefusedByName) {
  EXPECT_NO_THROW(check_capabilities(good()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<const char*, std::function<void(DeviceCapabilities&)>>> wrong{
      {"force_max", [](DeviceCapabilities& d) { d.force_max = d.force_sustained = 0.0; }},
      {"force_max", [&](DeviceCapabilities& d) { d.force_max = nan; }},
      {"force_sustained", [](DeviceCapabilities& d) { d.force_sustained = 8.1; }},
      {"force_sustained", [&](DeviceCapabilities& d) { d.force_sustained = nan; }},
      {"torque_max", [](DeviceCapabilities& d) { d.torque_max = -1.0; }},
      {"torque_max", [](DeviceCapabilities& d) { d.torque_max = 0.1; }},       // without axes for it
      {"torque_max", [](DeviceCapabilities& d) { d.actuated.rotation = 3; }},  // and the other way round
      {"torque_sustained", [](DeviceCapabilities& d) { d.torque_sustained = 0.1; }},
      {"axes", [](DeviceCapabilities& d) { d.sensed.rotation = 4; }},
      {"axes", [](DeviceCapabilities& d) { d.actuated.translation = -1; }},
      {"axes", [](DeviceCapabilities& d) { d.actuated.translation = 2; }},  // of 3 that it senses
      {"axes",
       [](DeviceCapabilities& d) {
         d.torque_max = 0.1;
         d.actuated.rotation = 3;
         d.sensed.rotation = 0;
       }},
      {"stiffness_max", [&](DeviceCapabilities& d) { d.stiffness_max = nan; }},
      {"damping_max", [](DeviceCapabilities& d) { d.damping_max = -1.0; }},
      {"damping", [](DeviceCapabilities& d) { d.damping = 1.0; }},  // known from nowhere
      {"angular_damping", [](DeviceCapabilities& d) { d.angular_damping = 1e-3; }},
      {"angular_damping must not", [](DeviceCapabilities& d) { d.angular_damping = -1e-3; }},
      {"delay", [](DeviceCapabilities& d) { d.delay = -1e-3; }},
      {"watchdog", [&](DeviceCapabilities& d) { d.watchdog = nan; }},
      {"workspace", [](DeviceCapabilities& d) { d.workspace = -1.0; }},
      {"rate", [](DeviceCapabilities& d) { d.rate = 0.0; }}};
  for (const auto& [figure, spoil] : wrong) {
    DeviceCapabilities bad = good();
    spoil(bad);
    try {
      check_capabilities(bad);
      ADD_FAILURE() << figure;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'arm'"), testing::HasSubstr(figure)));
    }
  }
}

/// A device whose opening goes as a test wants it.
struct Opened : HapticDevice {
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double, DeviceReading&) override { return false; }
  void write(const Wrench&) override {}
  void enable() override { set_status(enabled, "its key is turned to off"); }
  void open() override { set_status(first, "lay it into its cradle"); }
  void calibrate() override {
    ++calibrations;
    if (cradle_is_empty) throw Error("arm: the cradle is empty; lay it in and start again");
    set_status(DeviceStatus::kOpen);
  }

  DeviceCapabilities can = good();
  DeviceStatus first = DeviceStatus::kOpen, enabled = DeviceStatus::kEnabled;
  bool cradle_is_empty = false;
  int calibrations = 0;
};

TEST(OpenDevice, CalibratesWhatNeedsItAndSaysSoBefore) {
  Opened device;
  std::vector<std::string> said;
  const auto say = [&](const std::string& line) {
    EXPECT_EQ(device.calibrations, 0);
    said.push_back(line);
  };
  EXPECT_EQ(device.status(), DeviceStatus::kClosed);
  open_device(device, say);
  EXPECT_EQ(device.status(), DeviceStatus::kOpen);
  EXPECT_TRUE(said.empty());
  device.first = DeviceStatus::kNeedsCalibration;
  open_device(device, say);
  EXPECT_EQ(device.status(), DeviceStatus::kOpen);
  EXPECT_EQ(said, std::vector<std::string>{"arm needs calibration: lay it into its cradle"});
  EXPECT_EQ(device.calibrations, 1);
  open_device(device, {});
  EXPECT_EQ(device.calibrations, 2);
}

TEST(OpenDevice, ClosesWhatCannotBeUsed) {
  Opened faulty;
  faulty.first = DeviceStatus::kFault;
  EXPECT_THROW(open_device(faulty, {}), Error);
  EXPECT_EQ(faulty.status(), DeviceStatus::kClosed);
  Opened uncalibrated;
  uncalibrated.first = DeviceStatus::kNeedsCalibration;
  uncalibrated.cradle_is_empty = true;
  EXPECT_THROW(open_device(uncalibrated, {}), Error);
  EXPECT_EQ(uncalibrated.status(), DeviceStatus::kClosed);
  Opened wrong;
  wrong.can.rate = 0.0;
  EXPECT_THROW(open_device(wrong, {}), Error);
  EXPECT_EQ(wrong.status(), DeviceStatus::kClosed);
}

TEST(EnableDevice, RefusesWhatIsNotEnabled) {
  Opened device;
  open_device(device, {});
  EXPECT_NO_THROW(enable_device(device));
  for (const DeviceStatus status : {DeviceStatus::kOpen, DeviceStatus::kFault}) {
    device.enabled = status;
    EXPECT_THAT(test::message_of<Error>([&] { enable_device(device); }),
                testing::AllOf(testing::HasSubstr("'arm'"),
                               testing::HasSubstr(std::string(to_string(status)) + ", not enabled"),
                               testing::HasSubstr("its key is turned to off")));
  }
}

TEST(CloseDevice, WaitsForItAndNotForever) {
  Opened device;
  open_device(device, {});
  EXPECT_TRUE(close_device(device, 10.0));
  EXPECT_EQ(device.status(), DeviceStatus::kClosed);

  struct Hangs final : Opened {
    void close() noexcept override {
      goes_on.wait(false);
      left = true;
      left.notify_one();
    }
    std::atomic<bool> goes_on = false, left = false;
  };
  Hangs hung;
  EXPECT_FALSE(close_device(hung, 0.05));
  hung.goes_on = true;
  hung.goes_on.notify_one();
  hung.left.wait(false);
}

}  // namespace
}  // namespace palpate
