// A client that is the device keeps the contract that drivers have to, with a hand that sends poses.
#include <palpate/device/testing/device_contract.h>

#include <cmath>

#include <palpate/gateway/client_hand.h>
#include <support/allocation_guard.h>

namespace palpate::test {
namespace {

std::unique_ptr<ClientHand> hand;

std::unique_ptr<HapticDevice> client() {
  hand = std::make_unique<ClientHand>();
  DeviceCapabilities can;
  can.name = "client";
  can.force_max = 8.0;
  can.rate = 60.0;
  return std::make_unique<ClientDevice>(can, *hand);
}

/// A pose every third tick, measured half a millisecond ago.
void send_pose(double t) {
  if (std::lround(1e3 * t) % 3 != 0) return;
  DevicePose pose;
  pose.position.x() = 0.1 * std::sin(t);
  hand->put(pose, t - 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Client, HapticDeviceContract,
                         ::testing::Values(DeviceUnderTest{
                             "client", client, {.feed = send_pose, .allocations = allocations_of_thread}}));

}  // namespace
}  // namespace palpate::test
