/// \file
/// Exception guard around a device driver.
#pragma once

#include <array>
#include <atomic>
#include <string_view>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Stands between a loop and a device: a driver that throws on the loop's thread, which its contract forbids,
/// ends only its own hand and not the program with all other hands. From then on there are no readings, the
/// motors are off, and no function of the driver but stop() is called: the force falls as for an unplugged
/// device. The owner of the device opens and closes it.
class GuardedDevice final : public HapticDevice {
 public:
  /// `device` must outlive this object.
  explicit GuardedDevice(HapticDevice& device) : device_(device) {}

  const DeviceCapabilities& capabilities() const override { return device_.capabilities(); }
  bool read(double t, DeviceReading& reading) override;
  void wait(const LoopClock& clock, double until) override;
  void write(const Wrench& wrench) override;
  void stop() noexcept override { device_.stop(); }

  /// Message of the exception that the driver threw; empty if none. Any thread.
  std::string_view thrown() const { return {text_.data(), length_.load(std::memory_order_acquire)}; }

 private:
  template <class Call>
  bool guard(const Call& call);

  HapticDevice& device_;
  std::array<char, 256> text_{};  ///< written once: no allocation on the loop's thread
  std::atomic<std::size_t> length_ = 0;
};

}  // namespace palpate
