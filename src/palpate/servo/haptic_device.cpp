#include <palpate/servo/haptic_device.h>

#include <array>
#include <cstddef>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {

std::string_view to_string(DeviceStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"closed", "needs calibration", "open", "enabled", "fault"};
  return kNames[static_cast<std::size_t>(status)];
}

void open_device(HapticDevice& device, const std::function<void(const std::string&)>& say) {
  try {
    device.open();
    const std::string& name = device.capabilities().name;
    check_capabilities(device.capabilities());
    if (device.status() == DeviceStatus::kNeedsCalibration) {
      if (say) say(fmt::format("{} needs calibration: {}", name, device.status_text()));
      device.calibrate();
    }
    if (device.status() != DeviceStatus::kOpen)
      throw Error("device '{}': {}: {}; switch it off and on, and try again", name,
                  to_string(device.status()), device.status_text());
  } catch (...) {
    device.close();
    throw;
  }
}

}  // namespace palpate
