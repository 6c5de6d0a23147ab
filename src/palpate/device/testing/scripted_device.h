/// \file
/// Scripted device with injected failures, for tests.
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/servo/haptic_device.h>

namespace palpate::test {

/// What a device may do wrong.
enum class DeviceFault : std::uint8_t {
  kLate,        ///< tells where the handle was ScriptedDevice::kLate ago, with that time
  kSilent,      ///< has no new reading
  kNan,         ///< a position that is no number
  kFrozen,      ///< the pose of the beginning, with new times
  kNoisy,       ///< up to ScriptedDevice::kNoise beside the handle, another way each time
  kReversed,    ///< the x axis has the wrong sign
  kSaturating,  ///< motors show a quarter of what they are told
  kUnplugged,   ///< is not there: no readings, motors off, DeviceStatus::kFault
};

/// A fault from `begin` to `end`, on the loop's clock. Unit: [s].
struct ScriptedFault {
  double begin = 0.0;
  double end = std::numeric_limits<double>::infinity();
  DeviceFault fault = DeviceFault::kSilent;
};

/// A handle that goes a given way whatever the force, read without error but for a script of faults. It keeps
/// the whole contract of HapticDevice, calibration included, but for what the script says.
class ScriptedDevice final : public HapticDevice {
 public:
  using Path = std::function<Pose(double t)>;

  /// \param path of the handle, at a time of the loop's clock; called by read(), must not fail
  ScriptedDevice(DeviceCapabilities capabilities, Path path, std::vector<ScriptedFault> script = {})
      : capabilities_(std::move(capabilities)), path_(std::move(path)), script_(std::move(script)) {}
  ~ScriptedDevice() override { close(); }

  void open() override {
    if (status() != DeviceStatus::kClosed) throw Error("{}: is open already; close it", capabilities_.name);
    set_status(calibrated_ ? DeviceStatus::kOpen : DeviceStatus::kNeedsCalibration, "move it to its stops");
  }
  void calibrate() override {
    calibrated_ = true;
    set_status(DeviceStatus::kOpen);
  }
  void enable() override {
    if (status() != DeviceStatus::kOpen) throw Error("{}: is not open; open it", capabilities_.name);
    force_on_ = came_back_ = false;
    set_status(DeviceStatus::kEnabled);
  }
  void close() noexcept override {
    stop();
    set_status(DeviceStatus::kClosed);
  }

  const DeviceCapabilities& capabilities() const override { return capabilities_; }

  bool read(double t, DeviceReading& reading) override {
    plug(!has(DeviceFault::kUnplugged, t));
    if (status() == DeviceStatus::kClosed || status() == DeviceStatus::kFault) return false;
    if (has(DeviceFault::kSilent, t) || (read_ && !(t > read_at_))) return false;
    const double measured = has(DeviceFault::kLate, t) ? t - kLate : t;
    if (read_ && measured < told_.t) return false;  // what is late comes in order all the same
    const Pose pose = spoilt(path_(measured), t);
    const double dt = measured - told_.t;
    Twist velocity;
    if (read_ && dt > 0.0) velocity.linear = (pose.position - told_.pose.position) / dt;
    reading = told_ = {measured, DevicePose(pose), velocity, plugged_in_};
    read_at_ = t;
    read_ = true;
    return true;
  }

  void write(const Wrench& wrench) override {
    written_ = wrench;
    if (wrench.force.isZero(0.0) && wrench.torque.isZero(0.0)) came_back_ = false;
    force_on_.store(status() == DeviceStatus::kEnabled && !came_back_, std::memory_order_relaxed);
  }
  void stop() noexcept override { force_on_.store(false, std::memory_order_relaxed); }

  /// What the motors show. The loop's thread, or any while there is none.
  Wrench shown() const {
    if (status() != DeviceStatus::kEnabled || !force_on_.load(std::memory_order_relaxed)) return {};
    const double share = has(DeviceFault::kSaturating, read_at_) ? kSaturated : 1.0;
    return {share * written_.force, share * written_.torque};
  }

  static constexpr double kLate = 0.03;       ///< Unit: [s].
  static constexpr double kNoise = 0.05;      ///< Unit: [m].
  static constexpr double kSaturated = 0.25;  ///< of what is written

 private:
  bool has(DeviceFault fault, double t) const {
    for (const ScriptedFault& f : script_)
      if (f.fault == fault && f.begin <= t && t < f.end) return true;
    return false;
  }

  /// It comes back by itself, enabled as it was.
  void plug(bool in) {
    if (!in && status() == DeviceStatus::kEnabled) set_status(DeviceStatus::kFault, "it is not plugged in");
    if (!in) stop();
    if (!in || status() != DeviceStatus::kFault) return;
    ++plugged_in_;
    came_back_ = true;
    set_status(DeviceStatus::kEnabled);
  }

  Pose spoilt(Pose pose, double t) {
    if (has(DeviceFault::kFrozen, t) && read_) pose = told_.pose.in_device_frame();
    if (has(DeviceFault::kReversed, t)) pose.position.x() *= -1.0;
    if (has(DeviceFault::kNoisy, t)) {
      noise_ = noise_ * 1664525U + 1013904223U;  // Numerical Recipes' generator
      pose.position.y() += kNoise * (static_cast<double>(noise_) / 2147483648.0 - 1.0);
    }
    if (has(DeviceFault::kNan, t)) pose.position.z() = std::numeric_limits<double>::quiet_NaN();
    return pose;
  }

  DeviceCapabilities capabilities_;
  Path path_;
  std::vector<ScriptedFault> script_;
  bool calibrated_ = false;
  std::uint32_t plugged_in_ = 0;  ///< how often it came back
  bool came_back_ = false;        ///< and has not been written no force yet
  bool read_ = false;             ///< there was a reading
  double read_at_ = 0.0;          ///< when read() had the last one. Unit: [s].
  DeviceReading told_;
  Wrench written_;
  std::atomic<bool> force_on_ = false;
  std::uint32_t noise_ = 18;
};

}  // namespace palpate::test
