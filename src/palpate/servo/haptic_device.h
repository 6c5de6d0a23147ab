/// \file
/// Interface of haptic device drivers.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include <palpate/base/clock.h>
#include <palpate/servo/device_capabilities.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

/// Life-cycle state of a device; see HapticDevice.
enum class DeviceStatus : std::uint8_t {
  kClosed,            ///< not connected, motors off
  kNeedsCalibration,  ///< connected, motors off; poses not yet valid
  kOpen,              ///< connected, motors off; readings are valid
  kEnabled,           ///< motors apply the written wrench
  kFault,             ///< disconnected or defective; motors off
};
std::string_view to_string(DeviceStatus status);

/// A haptic device. A driver is one class that implements this interface; the wrenches it receives have
/// passed a SafetyGovernor, so that it need not enforce limits.
///
///     kClosed --open()--> [kNeedsCalibration --calibrate()-->] kOpen --enable()--> kEnabled
///     any status --close()--> kClosed         kEnabled --the device fails--> kFault --it is back--> kEnabled
///
///  - open(), calibrate(), enable() and close() are called by the owner's thread, while no loop runs; close()
///    may be called by another thread while the owner's waits (close_device()). They may block, allocate and
///    (except close()) throw.
///  - wait(), read() and write() are called by the loop's thread, once per tick and in this order. They do
///    not throw, allocate, lock or log.
///  - stop(), status() and status_text() may be called by any thread or signal handler at any time, and do
///    not do so either.
///
/// If an enabled device fails, read() returns false until the device is back. It may recover by itself, with
/// another DeviceReading::hand and its motors off until a write() of zero wrench: however short the outage,
/// the previous force ramps to zero without being applied, and the start gate then waits until the requested
/// wrench is small. palpate/device/testing/device_contract.h contains the contract as tests.
class HapticDevice {
 public:
  HapticDevice() = default;
  /// Closes the device: every driver's destructor calls its own close().
  virtual ~HapticDevice() = default;
  HapticDevice(const HapticDevice&) = delete;
  HapticDevice& operator=(const HapticDevice&) = delete;

  /// \name On the owner's thread, while no loop runs
  /// @{
  /// Connects. The status is then kOpen or kNeedsCalibration. \throws Error that says what to do, if there is
  /// no such device or it is in use; the status is then kClosed.
  virtual void open() { set_status(DeviceStatus::kOpen); }
  /// Determines the pose of the handle, by the motors or by asking a person to move it, and returns once it
  /// is known. Called if the status is kNeedsCalibration. \throws Error that says what to do.
  virtual void calibrate() { set_status(DeviceStatus::kOpen); }
  /// Turns the motors on, with zero force. \pre kOpen \throws Error that says what to do.
  virtual void enable() { set_status(DeviceStatus::kEnabled); }
  /// Turns the motors off and releases the device, which may be opened again. Does nothing if it is closed.
  virtual void close() noexcept { set_status(DeviceStatus::kClosed); }
  /// @}

  /// Valid once the device is open, and constant until it is opened again. Any thread.
  virtual const DeviceCapabilities& capabilities() const = 0;

  /// \name On the loop's thread
  /// @{
  /// Gets the newest reading, if there is a new one. \param t now, on the loop's clock, as is
  /// DeviceReading::t. Unit: [s]. \returns false, with `reading` unchanged, if there is none: readings are
  /// never invented. DeviceReading::t never decreases and is not after `t`; poses are finite and their
  /// quaternions of unit norm. Blocks no longer than the device takes to answer.
  virtual bool read(double t, DeviceReading& reading) = 0;

  /// Waits for the next tick, at most until `until`. A device with asynchronous readings, as over a network,
  /// returns early at each reading. Unit: [s], on `clock`, which is the loop's.
  virtual void wait(const LoopClock& clock, double until) { clock.sleep_until(until); }

  /// Sets the wrench that the motors apply from now on, F_H_D, torque about the handle; none unless enabled.
  /// \pre within capabilities(), and finite.
  virtual void write(const Wrench& wrench) = 0;

  /// Called before each tick of a loop that is to end. A device that moves the handle by itself brakes it in
  /// the next calls of read() and write(), until the loop has ended. \returns true once the handle is at
  /// rest, or should have been: the loop goes on until then.
  virtual bool come_to_rest() { return true; }
  /// @}

  /// \name From any thread, and in signal handlers
  /// @{
  /// Turns the motors off at once, because the loop no longer ticks or the program is about to terminate. May
  /// be called at any time from construction to destruction, also while another thread is in another
  /// function: it neither locks nor allocates. The next write() applies a wrench again; that wrench is zero.
  /// A device without motors on this machine has nothing to do: its client detects the silence.
  virtual void stop() noexcept {}

  DeviceStatus status() const noexcept { return status_.load(std::memory_order_acquire); }
  /// Short explanation of the status for a person: what to calibrate, what has failed; often empty.
  std::string_view status_text() const noexcept { return text_.load(std::memory_order_relaxed); }
  /// @}

 protected:
  /// Any thread. \param text string literal: must have static lifetime
  void set_status(DeviceStatus status, const char* text = "") noexcept {
    text_.store(text, std::memory_order_relaxed);
    status_.store(status, std::memory_order_release);
  }

 private:
  std::atomic<DeviceStatus> status_ = DeviceStatus::kClosed;
  std::atomic<const char*> text_ = "";
};

/// Opens a device, calibrates it if necessary, and checks its capabilities. \param say receives one line
/// before a calibration is awaited; may be empty \throws Error, which names the device, as open() and
/// calibrate() do; the device is then closed. Owner's thread.
void open_device(HapticDevice& device, const std::function<void(const std::string&)>& say);

/// Enables an open device. \throws Error as enable() does, and one that names the device if it is not enabled
/// afterwards; its motors may then be on until it is closed. Owner's thread.
void enable_device(HapticDevice& device);

/// Closes a device, on a thread of its own. Owner's thread, which waits meanwhile. \param patience longest
/// wait for close(). Unit: [s]. \returns false if close() has not returned then: it is left behind with its
/// thread, and the device must not be destroyed.
bool close_device(HapticDevice& device, double patience);

}  // namespace palpate
