/// \file
/// The interface of what measures a hand's force and takes a motion: devices of the admittance type.
#pragma once

#include <cstdint>

#include <palpate/base/clock.h>
#include <palpate/servo/admittance_controller.h>
#include <palpate/servo/device_capabilities.h>

namespace palpate {

/// What such a device says at one instant.
struct MotionReading {
  double t = 0.0;   ///< when it was measured, on the loop's clock. Unit: [s].
  DevicePose pose;  ///< X_DH: of the TCP H, as measured
  Twist velocity;   ///< V_DH
  /// Of the hand on the handle, as the force sensor says, torque about the TCP; along the axes of the
  /// device's frame. Bias and all.
  Wrench user;
  double user_t = 0.0;  ///< when that was measured; the same again where it was not. Unit: [s].
  std::uint32_t hand = 0, buttons = 0;  ///< as DeviceReading
};

/// What a device makes of a motion that it is told.
struct MotionAnswer {
  MotionSetpoint motion;    ///< that it will follow
  bool held = false;        ///< that is not what it was told, by more than it takes for following
  const char* reason = "";  ///< why, for a person; a literal
  int joint = -1;           ///< which joint holds it; -1: none in particular
};

/// A device with its own position control. The life of a HapticDevice: the owner opens, enables and closes
/// it, the loop's thread reads and moves it, once a tick and in this order, and any thread may stop it.
class MotionDevice {
 public:
  MotionDevice() = default;
  virtual ~MotionDevice() = default;
  MotionDevice(const MotionDevice&) = delete;
  MotionDevice& operator=(const MotionDevice&) = delete;

  /// \name On the owner's thread, while no loop runs. As of HapticDevice.
  /// @{
  virtual void open() {}
  virtual void enable() {}
  virtual void close() noexcept {}
  /// @}

  /// With Causality::kAdmittance. `force_max` and `torque_max` are what the sensor measures.
  virtual const DeviceCapabilities& capabilities() const = 0;

  /// \name On the loop's thread: no allocation, locks, exceptions or I/O
  /// @{
  /// The newest reading, if there is one. \param t now. Unit: [s].
  virtual bool read(double t, MotionReading& reading) = 0;
  /// Where it shall be at the next tick. \pre finite, and within what it was made for
  virtual MotionAnswer move(const MotionSetpoint& motion, double dt) = 0;
  virtual void wait(const LoopClock& clock, double until) { clock.sleep_until(until); }
  /// @}

  /// Comes to rest by itself, each joint as fast as it may; the next move() goes on from there. From any
  /// thread, also a signal handler.
  virtual void stop() noexcept {}
};

}  // namespace palpate
