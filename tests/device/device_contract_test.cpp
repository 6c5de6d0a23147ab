// The devices of this folder keep the contract that drivers have to.
#include <palpate/device/testing/device_contract.h>

#include <cmath>

#include <palpate/device/playback_device.h>
#include <palpate/device/profiles.h>
#include <palpate/device/testing/scripted_device.h>
#include <support/allocation_guard.h>

namespace palpate::test {
namespace {

Pose swing(double t) {
  Pose pose;
  pose.position.x() = 0.01 * std::sin(5.0 * t);
  return pose;
}

std::unique_ptr<HapticDevice> simulated(const DeviceProfile& profile) {
  return std::make_unique<SimulatedDevice>(profile.capabilities, profile.plant, HandProperties{}, swing);
}

Wrench shown_by_simulated(const HapticDevice& device) {
  return dynamic_cast<const SimulatedDevice&>(device).motors();
}

std::unique_ptr<HapticDevice> playback() {
  Trajectory path(2);
  path[1].t = 0.2;
  path[1].pose.position = {0.02, 0, 0};
  return std::make_unique<PlaybackDevice>(device_profile("delta.3").capabilities, path);
}

/// It senses no rotation, and is silent for a while.
std::unique_ptr<HapticDevice> scripted() {
  DeviceCapabilities can;
  can.name = "scripted";
  can.force_max = 10.0;
  can.sensed.rotation = 0;
  return std::make_unique<ScriptedDevice>(can, swing,
                                          std::vector<ScriptedFault>{{0.05, 0.07, DeviceFault::kSilent}});
}

Wrench shown_by_scripted(const HapticDevice& device) {
  return dynamic_cast<const ScriptedDevice&>(device).shown();
}

std::vector<DeviceUnderTest> devices() {
  std::vector<DeviceUnderTest> all;
  for (const DeviceProfile& profile : device_profiles())
    all.push_back({profile.capabilities.name,
                   [&profile] { return simulated(profile); },
                   {.shown = shown_by_simulated, .allocations = allocations_of_thread}});
  all.push_back({"playback", playback, {.allocations = allocations_of_thread}});
  all.push_back({"scripted", scripted, {.shown = shown_by_scripted, .allocations = allocations_of_thread}});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Devices, HapticDeviceContract, ::testing::ValuesIn(devices()));

}  // namespace
}  // namespace palpate::test
