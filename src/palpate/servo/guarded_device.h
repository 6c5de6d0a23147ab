/// \file
/// Exception guard around a device driver.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string_view>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Stands between a loop and a device: a driver that throws on the loop's thread, which its contract forbids,
/// ends only its own hand and not the program with all other hands. From then on there are no readings, the
/// motors are off, and no function of the driver but stop() is called: the force falls as for an unplugged
/// device. A driver that does not return from a call can be abandoned, with the thread that called it. The
/// owner of the device opens and closes it.
class GuardedDevice final : public HapticDevice {
 public:
  /// `device` must outlive this object.
  explicit GuardedDevice(HapticDevice& device);
  ~GuardedDevice() override;

  const DeviceCapabilities& capabilities() const override { return device_.capabilities(); }
  bool read(double t, DeviceReading& reading) override;
  void wait(const LoopClock& clock, double until) override;
  void write(const Wrench& wrench) override;
  bool come_to_rest() override;
  /// The next write() is of zero wrench. One that is being made may end after it.
  void stop() noexcept override;

  /// Abandons a call that does not return: should the driver ever return from it, its thread waits for the
  /// end of the program and touches nothing but the driver. Another thread than the loop's. \returns false if
  /// the loop is not in a call of the driver. After true, this object may be destroyed, and the device must
  /// not be.
  bool abandon() noexcept;

  /// Message of the exception that the driver threw; empty if none. Any thread.
  std::string_view thrown() const { return {text_.data(), length_.load(std::memory_order_acquire)}; }

 private:
  struct Call;
  template <class Work>
  bool guard(const Work& work);

  HapticDevice& device_;
  std::unique_ptr<Call> owned_;  ///< null if the call is abandoned, which outlives this object
  Call& call_;
  std::array<char, 256> text_{};  ///< written once: no allocation on the loop's thread
  std::atomic<std::size_t> length_ = 0;
};

}  // namespace palpate
