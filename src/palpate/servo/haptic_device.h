/// \file
/// The small interface that everything with a handle and motors is behind.
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

/// Where a device is in its life; see HapticDevice.
enum class DeviceStatus : std::uint8_t {
  kClosed,            ///< not connected, motors off
  kNeedsCalibration,  ///< connected, motors off; its poses are not right yet
  kOpen,              ///< connected, motors off; may be read
  kEnabled,           ///< motors show what is written
  kFault,             ///< connected no longer, or out of order; motors off
};
std::string_view to_string(DeviceStatus status);

/// A device. A driver is one class that implements it; what it sends has gone through a SafetyGovernor, so
/// that it has no limits of its own to keep.
///
///     kClosed --open()--> [kNeedsCalibration --calibrate()-->] kOpen --enable()--> kEnabled
///     any status --close()--> kClosed         kEnabled --the device fails--> kFault --it is back--> kEnabled
///
///  - open(), calibrate(), enable() and close() belong to the owner's thread, while no loop runs. They may
///    block, allocate and (but for close()) throw.
///  - wait(), read() and write() belong to the loop's thread, once a tick and in this order. They do not
///    throw, allocate, lock or log.
///  - stop(), status() and status_text() may be called by any thread or signal handler at any time, and do
///    none of that either.
///
/// A device that fails while it is enabled answers false from read() until it is back. It may come back by
/// itself, with another DeviceReading::hand, and motors off until a write() of no force: however short it was
/// away, what was felt before falls to zero unseen, and waits in the gate until what is asked for is small.
/// palpate/device/testing/device_contract.h has the contract as tests.
class HapticDevice {
 public:
  HapticDevice() = default;
  /// Closes it: a driver's destructor calls its own close().
  virtual ~HapticDevice() = default;
  HapticDevice(const HapticDevice&) = delete;
  HapticDevice& operator=(const HapticDevice&) = delete;

  /// \name On the owner's thread, while no loop runs
  /// @{
  /// Connects. Afterwards it is kOpen, or kNeedsCalibration. \throws Error that says what to do, if there is
  /// no such device or it is in use; it is then kClosed.
  virtual void open() { set_status(DeviceStatus::kOpen); }
  /// Finds where the handle is, by motors or by a person who is asked to move it, and returns once it is
  /// known. Called if the status is kNeedsCalibration. \throws Error that says what to do.
  virtual void calibrate() { set_status(DeviceStatus::kOpen); }
  /// Motors on, with no force. \pre kOpen \throws Error that says what to do.
  virtual void enable() { set_status(DeviceStatus::kEnabled); }
  /// Motors off, and lets go of the device. May be opened again. Does nothing where it is closed.
  virtual void close() noexcept { set_status(DeviceStatus::kClosed); }
  /// @}

  /// Known once it is open, and fixed until it is opened anew. Any thread.
  virtual const DeviceCapabilities& capabilities() const = 0;

  /// \name On the loop's thread
  /// @{
  /// The newest reading, if there is a new one. \param t now, on the loop's clock, which DeviceReading::t is
  /// on, too. Unit: [s]. \returns false, and leaves `reading` alone, where there is none: a reading that was
  /// not measured is never made up. DeviceReading::t never falls and is not after `t`; poses are finite and
  /// their quaternions of unit norm. Blocks for no longer than the device takes to answer.
  virtual bool read(double t, DeviceReading& reading) = 0;

  /// Waits for the next tick, no longer than until `until`. A device whose readings come when they come, over
  /// a network, ends it early with each. Unit: [s], on `clock`, which is the loop's.
  virtual void wait(const LoopClock& clock, double until) { clock.sleep_until(until); }

  /// What the motors show from now on, F_H_D, torque about the handle; nothing unless it is enabled. \pre
  /// within capabilities(), and finite.
  virtual void write(const Wrench& wrench) = 0;
  /// @}

  /// \name From any thread, and in signal handlers
  /// @{
  /// Motors off, at once: the loop does not tick any more, or the program is about to die. At any time from
  /// construction to destruction, also while another thread is in another function: it locks nothing and
  /// takes no memory. The next write() shows a wrench again; it is of no force. A device without motors of
  /// this machine has nothing to do: a client finds out by the silence.
  virtual void stop() noexcept {}

  DeviceStatus status() const noexcept { return status_.load(std::memory_order_acquire); }
  /// Why, in a few words, for a person: what is to be calibrated, what has failed; often empty.
  std::string_view status_text() const noexcept { return text_.load(std::memory_order_relaxed); }
  /// @}

 protected:
  /// From any thread. \param text a literal: it must live for ever
  void set_status(DeviceStatus status, const char* text = "") noexcept {
    text_.store(text, std::memory_order_relaxed);
    status_.store(status, std::memory_order_release);
  }

 private:
  std::atomic<DeviceStatus> status_ = DeviceStatus::kClosed;
  std::atomic<const char*> text_ = "";
};

/// Opens a device, calibrates it where it needs that, and checks what it says of itself. \param say is told a
/// line before it waits for a calibration; may be empty \throws Error, which names the device, as open() and
/// calibrate() do; it is then closed. Owner's thread.
void open_device(HapticDevice& device, const std::function<void(const std::string&)>& say);

}  // namespace palpate
