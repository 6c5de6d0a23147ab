// Devices from shared libraries: good ones keep the contract, all others are refused with one line.
#include <palpate/device/device_plugin.h>
#include <palpate/device/plugin_device.h>

#include <cmath>
#include <fstream>
#include <string>

#include <gmock/gmock.h>

#include <palpate/base/error.h>
#include <palpate/device/testing/device_contract.h>
#include <palpate/servo/servo_tick.h>
#include <support/allocation_guard.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string plugin(const std::string& name) { return std::string(PALPATE_PLUGINS) + "/" + name + ".so"; }

INSTANTIATE_TEST_SUITE_P(
    Plugins, HapticDeviceContract,
    ::testing::Values(
        DeviceUnderTest{"pendulum",
                        [] { return make_plugin_device("plugin:" + plugin("pendulum") + ":0.1"); },
                        {.allocations = allocations_of_thread}},
        DeviceUnderTest{"exported",
                        [] { return make_plugin_device("plugin:" + plugin("exported_plugin")); },
                        {.allocations = allocations_of_thread}}));

std::string refusal(const std::string& text) {
  const std::string line = message_of<Error>([&] { open_device(*make_plugin_device(text), {}); });
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  return line;
}

TEST(PluginDevice, SaysWhatItsLibrarySays) {
  const auto device = make_plugin_device(plugin("pendulum"), "0.25");
  open_device(*device, {});
  const DeviceCapabilities& can = device->capabilities();
  EXPECT_EQ(can.name, "pendulum");
  EXPECT_EQ(can.force_max, 10.0);
  EXPECT_EQ(can.stiffness_max, 2000.0);
  EXPECT_EQ(can.watchdog, 0.05);
  EXPECT_EQ(can.sensed.rotation, 0);
  device->enable();
  DeviceReading reading;
  ASSERT_TRUE(device->read(0.5, reading));
  EXPECT_EQ(reading.t, 0.5);
  EXPECT_NEAR(reading.pose.position.z(), 0.25 + 0.03 * (1.0 + std::cos(1.5)), 1e-12);
  EXPECT_NEAR(reading.velocity.linear.z(), -0.09 * std::sin(1.5), 1e-12);
  EXPECT_FALSE(device->read(0.5, reading)) << "there is no other at the same time";
}

TEST(PluginDevice, RefusesWhatIsNoPlugin) {
  EXPECT_THAT(refusal("plugin:/nowhere/arm.so"),
              AllOf(HasSubstr("/nowhere/arm.so"), HasSubstr("no such file")));
  EXPECT_THAT(refusal("plugin:" PALPATE_PLUGINS), HasSubstr("no such file"));
  const TemporaryFile text("this is no library", "text.so");
  EXPECT_THAT(refusal("plugin:" + text.path()), AllOf(HasSubstr("text.so"), HasSubstr("cannot be loaded")));
  EXPECT_THAT(refusal("plugin:" + plugin("bad_no_symbol")),
              HasSubstr("is not a device plug-in: it does not export palpate_device_plugin"));
  EXPECT_THAT(refusal("arm.so"), HasSubstr("is neither plugin:PATH.so nor NAME:ARGUMENTS"));
  EXPECT_THAT(refusal("no_such:x"),
              AllOf(HasSubstr("there is no palpate_device_no_such.so in"), HasSubstr("plugin:PATH.so")));
}

TEST(PluginDevice, RefusesAnotherVersion) {
  EXPECT_THAT(refusal("plugin:" + plugin("bad_wrong_version")),
              HasSubstr("uses version 7 of the plug-in interface, this program version " +
                        std::to_string(PALPATE_DEVICE_PLUGIN_VERSION) + "; recompile it"));
  EXPECT_THAT(refusal("plugin:" + plugin("bad_refuses_host")), HasSubstr("uses another version"));
}

TEST(PluginDevice, RefusesAPluginThatLacksAFunction) {
  for (const char* name : {"bad_no_read", "bad_wrong_size"})
    EXPECT_THAT(refusal("plugin:" + plugin(name)), HasSubstr("lacks a required function")) << name;
}

TEST(PluginDevice, TellsWhyADeviceCannotBeMadeOrOpened) {
  EXPECT_THAT(refusal("plugin:" + plugin("bad_no_device")), HasSubstr("no arm is plugged in; plug it in"));
  EXPECT_THAT(refusal("plugin:" + plugin("bad_cannot_open")), HasSubstr("xxxx"));
  EXPECT_THAT(refusal("plugin:" + plugin("pendulum") + ":high"), HasSubstr("'high' is no height"));
  EXPECT_THAT(refusal("plugin:" + plugin("exported_plugin") + ":x"),
              HasSubstr("takes no arguments but nan and admittance, not 'x'"));
  EXPECT_THAT(refusal("plugin:" + plugin("exported_plugin") + ":admittance"),
              HasSubstr("it is of the admittance type, which a plug-in cannot bring to rest"));
  EXPECT_THAT(refusal("plugin:" + plugin("exported_plugin") + ":null"),
              HasSubstr("its factory returned no device; correct the plug-in"));
}

TEST(PluginDevice, RefusesCapabilitiesThatAreNotNumbersAndAStatusThatThereIsNot) {
  EXPECT_THAT(refusal("plugin:" + plugin("bad_nan_force")), HasSubstr("force_max must be positive"));
  EXPECT_THAT(refusal("plugin:" + plugin("bad_odd_status")),
              HasSubstr("the plug-in returned an unknown status"));
}

TEST(PluginDevice, HasTheDampingThatItsDriverTells) {
  const auto device = make_plugin_device("plugin:" + plugin("exported_plugin"));
  open_device(*device, {});
  EXPECT_EQ(device->capabilities().damping, 0.25);
  EXPECT_EQ(device->capabilities().angular_damping, 0.5e-3);
  EXPECT_EQ(device->capabilities().damping_source, DampingSource::kMeasured);
}

TEST(PluginDevice, NanFromADriverIsAFaultOfTheGovernor) {
  const auto device = make_plugin_device(plugin("exported_plugin"), "nan");
  open_device(*device, {});
  device->enable();
  SafetyGovernor governor(SafetyLimits::of(device->capabilities(), 1e-3));
  DeviceReading reading;
  bool failed = false;
  for (int k = 1; k < 400; ++k) {
    const double t = 1e-3 * k;
    if (device->read(t, reading)) governor.admit(reading, t);
    const Wrench sent = governor.release({}, 0.0);
    ASSERT_TRUE(sent.force.allFinite());
    failed = failed || governor.fault() == Fault::kBadPose;
  }
  EXPECT_TRUE(failed);
}

TEST(PluginDevice, TextThatNamesOne) {
  for (const char* text : {"plugin:a.so", "ros1:/omni", "haply_2:"}) EXPECT_TRUE(names_plugin(text)) << text;
  for (const char* text : {"", ":", "client", "a.so", "/a:b", "a b:c"})
    EXPECT_FALSE(names_plugin(text)) << text;
}

}  // namespace
}  // namespace palpate::test
