/// \file
/// The small interface that everything with a handle and motors is behind.
#pragma once

#include <palpate/base/clock.h>
#include <palpate/servo/device_capabilities.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

/// A device. A driver is one class that implements it; what it sends has gone through a SafetyGovernor.
///
/// One thread calls read() and write(), once a tick and in this order, and any thread stop(). Neither takes
/// memory, blocks for longer than the device takes to answer, or throws; a device that fails answers false
/// from read() until it is back.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;

  /// Does not change while the device is open.
  virtual const DeviceCapabilities& capabilities() const = 0;

  /// The newest reading, if there is a new one. \param t now, on the loop's clock, which DeviceReading::t is
  /// on, too. Unit: [s]. \returns false, and leaves `reading` alone, where there is none.
  virtual bool read(double t, DeviceReading& reading) = 0;

  /// Waits for the next tick, no longer than until `until`. A device whose readings come when they come, over
  /// a network, ends it early with each. Unit: [s], on `clock`, which is the loop's.
  virtual void wait(const LoopClock& clock, double until) { clock.sleep_until(until); }

  /// What the motors show from now on. \pre within capabilities(), and finite.
  virtual void write(const Wrench& wrench) = 0;

  /// Motors off, at once: the loop does not tick any more, or the program is about to die. May be called by
  /// any thread at any time, also while another one is in read() or write(), and by a signal handler: it
  /// locks nothing and takes no memory. The next write() shows a wrench again; it is of no force. A device
  /// without motors of this machine has nothing to do: a client finds out by the silence.
  virtual void stop() noexcept {}
};

}  // namespace palpate
