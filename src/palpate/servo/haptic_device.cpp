#include <palpate/servo/haptic_device.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <future>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {

std::string_view to_string(DeviceStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"closed", "needs calibration", "open", "enabled", "fault"};
  return kNames[static_cast<std::size_t>(status)];
}

namespace {

void require_status(const HapticDevice& device, DeviceStatus required) {
  if (device.status() == required) return;
  const std::string_view why = device.status_text();
  throw Error("device '{}': its status is {}, not {}{}{}; switch it off and on, and try again",
              device.capabilities().name, to_string(device.status()), to_string(required),
              why.empty() ? "" : ": ", why);
}

}  // namespace

void open_device(HapticDevice& device, const std::function<void(const std::string&)>& say) {
  try {
    device.open();
    check_capabilities(device.capabilities());
    if (device.status() == DeviceStatus::kNeedsCalibration) {
      if (say) say(fmt::format("{} needs calibration: {}", device.capabilities().name, device.status_text()));
      device.calibrate();
    }
    require_status(device, DeviceStatus::kOpen);
  } catch (...) {
    device.close();
    throw;
  }
}

void enable_device(HapticDevice& device) {
  device.enable();
  require_status(device, DeviceStatus::kEnabled);
}

bool close_device(HapticDevice& device, double patience) {
  std::packaged_task<void()> close([&device] { device.close(); });
  const std::future<void> closed = close.get_future();
  std::thread thread(std::move(close));
  constexpr std::chrono::duration<double> kLook(0.01);
  double waited = 0.0;  // by its own waits: a program that was stopped meanwhile has not waited
  while (closed.wait_for(kLook) != std::future_status::ready) {
    waited += kLook.count();
    if (waited < patience) continue;
    thread.detach();
    return false;
  }
  thread.join();
  return true;
}

}  // namespace palpate
