/// \file
/// Export of a C++ driver as a device plug-in.
#pragma once

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <palpate/device/device_plugin.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Creates a device from the arguments of a plug-in; never null. \throws std::exception that says what to do.
using DeviceFactory = std::unique_ptr<HapticDevice> (*)(const std::string& arguments);

/// Plug-in interface of the HapticDevice that `kMake` creates. In one source file of a shared library:
///
///     std::unique_ptr<palpate::HapticDevice> make(const std::string& arguments);
///     const PalpateDevicePlugin* palpate_device_plugin(uint32_t) { return
///     &palpate::ExportedDevice<make>::kPlugin; }
template <DeviceFactory kMake>
class ExportedDevice {
  /// The device and the plug-in's own clock, which wait() needs.
  struct Held {
    std::unique_ptr<HapticDevice> device;
    LoopClock clock;
  };

  static HapticDevice& of(void* held) { return *static_cast<Held*>(held)->device; }

  static void tell(const char* text, char* error, std::size_t size) {
    if (size == 0) return;
    const std::size_t length = std::min(std::strlen(text), size - 1);
    std::memcpy(error, text, length);
    error[length] = '\0';
  }

  template <class Work>
  static int guarded(char* error, std::size_t size, const Work& work) {
    try {
      work();
      return 0;
    } catch (const std::exception& failure) {
      tell(failure.what(), error, size);
    } catch (...) {
      tell("it failed for an unknown reason", error, size);
    }
    return 1;
  }

  static void* create(const char* arguments, char* error, std::size_t size) {
    Held* held = nullptr;
    guarded(error, size, [&] {
      auto device = kMake(arguments);
      if (device == nullptr) throw std::runtime_error("its factory returned no device; correct the plug-in");
      held = new Held{std::move(device), {}};
    });
    return held;
  }
  static void destroy(void* held) { delete static_cast<Held*>(held); }
  static int open(void* held, char* error, std::size_t size) {
    return guarded(error, size, [&] {
      HapticDevice& device = of(held);
      device.open();
      if (device.capabilities().kind != Causality::kAdmittance) return;
      device.close();
      throw std::runtime_error("it is of the admittance type, which a plug-in cannot bring to rest; link it");
    });
  }
  static int calibrate(void* held, char* error, std::size_t size) {
    return guarded(error, size, [&] { of(held).calibrate(); });
  }
  static int enable(void* held, char* error, std::size_t size) {
    return guarded(error, size, [&] { of(held).enable(); });
  }
  static void close(void* held) { of(held).close(); }

  static void capabilities(void* held, PalpateDeviceCapabilities* out) {
    const DeviceCapabilities& c = of(held).capabilities();
    *out = {};
    tell(c.name.c_str(), out->name, sizeof(out->name));
    out->force_max = c.force_max;
    out->torque_max = c.torque_max;
    out->force_sustained = c.force_sustained;
    out->torque_sustained = c.torque_sustained;
    out->stiffness_max = c.stiffness_max;
    out->damping_max = c.damping_max;
    out->damping = c.damping;
    out->angular_damping = c.angular_damping;
    out->damping_source = static_cast<int>(c.damping_source);
    out->delay = c.delay;
    out->watchdog = c.watchdog;
    out->workspace = c.workspace;
    out->rate = c.rate;
    out->sensed_translation = c.sensed.translation;
    out->sensed_rotation = c.sensed.rotation;
    out->actuated_translation = c.actuated.translation;
    out->actuated_rotation = c.actuated.rotation;
  }

  static int read(void* held, double t, PalpateDeviceReading* out) {
    DeviceReading reading;
    if (!of(held).read(t, reading)) return 0;
    const Eigen::Quaterniond& q = reading.pose.orientation;
    const double orientation[4] = {q.w(), q.x(), q.y(), q.z()};
    out->t = reading.t;
    std::copy_n(reading.pose.position.data(), 3, out->position);
    std::copy_n(orientation, 4, out->orientation);
    std::copy_n(reading.velocity.linear.data(), 3, out->linear_velocity);
    std::copy_n(reading.velocity.angular.data(), 3, out->angular_velocity);
    out->hand = reading.hand;
    out->buttons = reading.buttons;
    return 1;
  }
  static void wait(void* held, double seconds) {
    const LoopClock& clock = static_cast<Held*>(held)->clock;
    of(held).wait(clock, clock.now() + seconds);
  }
  static void write(void* held, const PalpateDeviceWrench* wrench) {
    const auto &f = wrench->force, &m = wrench->torque;
    of(held).write({{f[0], f[1], f[2]}, {m[0], m[1], m[2]}});
  }
  static void stop(void* held) { of(held).stop(); }
  static int status(void* held, const char** text) {
    *text = of(held).status_text().data();  // a literal, which ends with 0
    return static_cast<int>(of(held).status());
  }

 public:
  static constexpr PalpateDevicePlugin kPlugin{PALPATE_DEVICE_PLUGIN_VERSION,
                                               sizeof(PalpateDevicePlugin),
                                               create,
                                               destroy,
                                               open,
                                               calibrate,
                                               enable,
                                               close,
                                               capabilities,
                                               read,
                                               wait,
                                               write,
                                               stop,
                                               status};
};

}  // namespace palpate
