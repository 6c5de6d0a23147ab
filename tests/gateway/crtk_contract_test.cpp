// A device whose driver speaks CRTK keeps the contract of drivers.
#include <cmath>
#include <memory>

#include <palpate/device/testing/device_contract.h>
#include <support/allocation_guard.h>
#include <support/crtk_link.h>

namespace palpate::test {
namespace {

CrtkPeer* contract_peer = nullptr;
CrtkDevice* contract_device = nullptr;

std::unique_ptr<HapticDevice> contract() {
  auto peer = std::make_unique<CrtkPeer>();
  contract_peer = peer.get();
  auto device = std::make_unique<CrtkDevice>(crtk_options(), std::move(peer));
  contract_device = device.get();
  return device;
}

void contract_feed(double t) {
  Pose pose;
  pose.position.x() = 0.1 * std::sin(t);
  contract_device->take_pose({driver_now(), "base", "/arm"}, pose);
}

/// Once the device's own thread has sent what was written.
Wrench contract_shown(const HapticDevice&) {
  sleep_until(monotonic_now() + 0.03);
  return contract_peer->last().spatial;
}

INSTANTIATE_TEST_SUITE_P(Crtk, HapticDeviceContract,
                         ::testing::Values(DeviceUnderTest{"crtk",
                                                           contract,
                                                           {.real_time = true,
                                                            .feed = contract_feed,
                                                            .shown = contract_shown,
                                                            .allocations = allocations_of_thread}}));

}  // namespace
}  // namespace palpate::test
