/// \file
/// A device whose driver may throw after all.
#pragma once

#include <array>
#include <atomic>
#include <string_view>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// What a loop sees of a device in place of it, so that a driver that throws on the loop's thread, which its
/// contract forbids, ends its own hand and not the program with all other hands. From then on there is no
/// reading, the motors are off, and the driver is not called again but for stop(): the force falls as for a
/// device that is unplugged. Opened and closed by who owns the device.
class GuardedDevice final : public HapticDevice {
 public:
  /// `device` must outlive it.
  explicit GuardedDevice(HapticDevice& device) : device_(device) {}

  const DeviceCapabilities& capabilities() const override { return device_.capabilities(); }
  bool read(double t, DeviceReading& reading) override;
  void wait(const LoopClock& clock, double until) override;
  void write(const Wrench& wrench) override;
  void stop() noexcept override { device_.stop(); }

  /// What the driver threw; empty while it has thrown nothing. Any thread.
  std::string_view thrown() const { return {text_.data(), length_.load(std::memory_order_acquire)}; }

 private:
  template <class Call>
  bool guard(const Call& call);

  HapticDevice& device_;
  std::array<char, 256> text_{};  ///< written once: nothing is taken from the heap on the loop's thread
  std::atomic<std::size_t> length_ = 0;
};

}  // namespace palpate
