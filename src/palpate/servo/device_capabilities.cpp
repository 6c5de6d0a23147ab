#include <palpate/servo/device_capabilities.h>

#include <cmath>

#include <palpate/base/error.h>

namespace palpate {

void check_capabilities(const DeviceCapabilities& device) {
  const auto require = [&](bool good, const char* what) {
    if (!good) throw Error("device '{}': {}; correct its driver", device.name, what);
  };
  const auto not_negative = [](double v) { return v >= 0.0 && std::isfinite(v); };
  const auto axes = [](const DeviceAxes& a) {
    return a.translation >= 0 && a.translation <= 3 && a.rotation >= 0 && a.rotation <= 3;
  };
  require(device.force_max > 0.0 && std::isfinite(device.force_max), "force_max must be positive");
  require(not_negative(device.torque_max), "torque_max must not be negative");
  require(device.force_sustained >= 0.0 && device.force_sustained <= device.force_max,
          "force_sustained must be 0 to force_max");
  require(device.torque_sustained >= 0.0 && device.torque_sustained <= device.torque_max,
          "torque_sustained must be 0 to torque_max");
  require(axes(device.sensed) && axes(device.actuated), "it must have 0 to 3 axes of each kind");
  // Energy stored along an axis without output would be released along one with output. Which axes a smaller
  // number stands for is unknown, so that such work cannot be distinguished from the hand's.
  const auto all_or_none = [](int actuated, int sensed) { return actuated == 0 || actuated == sensed; };
  require(all_or_none(device.actuated.translation, device.sensed.translation) &&
              all_or_none(device.actuated.rotation, device.sensed.rotation),
          "of each kind, it must actuate all sensed axes or none");
  require((device.actuated.rotation > 0) == (device.torque_max > 0.0),
          "torque_max must be positive if it actuates rotation, else 0");
  require(not_negative(device.stiffness_max), "stiffness_max must not be negative");
  require(not_negative(device.damping_max), "damping_max must not be negative");
  require(not_negative(device.damping), "damping must not be negative");
  require(not_negative(device.angular_damping), "angular_damping must not be negative");
  require((device.damping == 0.0 && device.angular_damping == 0.0) ||
              device.damping_source != DampingSource::kUnknown,
          "damping and angular_damping must be 0 if their source is unknown");
  require(not_negative(device.delay), "delay must not be negative");
  require(not_negative(device.watchdog), "watchdog must not be negative");
  require(not_negative(device.workspace), "workspace must not be negative");
  require(device.rate > 0.0 && std::isfinite(device.rate), "rate must be positive");
}

}  // namespace palpate
