/// \file
/// Interface of admittance-type devices, which measure the hand's wrench and follow a commanded motion.
#pragma once

#include <cstdint>

#include <palpate/base/clock.h>
#include <palpate/servo/admittance_controller.h>
#include <palpate/servo/device_capabilities.h>

namespace palpate {

/// Reading of an admittance-type device at one instant.
struct MotionReading {
  double t = 0.0;   ///< when it was measured, on the loop's clock. Unit: [s].
  DevicePose pose;  ///< X_DH: of the TCP H, as measured
  Twist velocity;   ///< V_DH
  /// Wrench of the hand on the handle as measured by the force sensor, bias included; torque about the TCP,
  /// along the axes of the device's frame.
  Wrench user;
  double user_t = 0.0;  ///< time of that measurement; unchanged if there is no new one. Unit: [s].
  std::uint32_t hand = 0, buttons = 0;  ///< as DeviceReading
};

/// Answer of a device to a motion setpoint.
struct MotionAnswer {
  MotionSetpoint motion;    ///< motion that the device will follow
  bool held = false;        ///< it deviates from the setpoint by more than the tolerance for following
  const char* reason = "";  ///< reason for a person; a string literal
  int joint = -1;           ///< limiting joint; -1 = none in particular
};

/// A device with its own position control. Life cycle as HapticDevice: the owner opens, enables and closes
/// it, the loop's thread reads and moves it, once per tick and in this order, and any thread may stop it.
class MotionDevice {
 public:
  MotionDevice() = default;
  virtual ~MotionDevice() = default;
  MotionDevice(const MotionDevice&) = delete;
  MotionDevice& operator=(const MotionDevice&) = delete;

  /// \name On the owner's thread, while no loop runs; as HapticDevice
  /// @{
  virtual void open() {}
  virtual void enable() {}
  virtual void close() noexcept {}
  /// @}

  /// Causality::kAdmittance; `force_max` and `torque_max` are the range of the sensor.
  virtual const DeviceCapabilities& capabilities() const = 0;

  /// \name On the loop's thread: no allocation, locks, exceptions or I/O
  /// @{
  /// Gets the newest reading. \returns false if there is none. \param t now. Unit: [s].
  virtual bool read(double t, MotionReading& reading) = 0;
  /// Commands the motion at the next tick. Where the device has braked by itself, because it was told to
  /// stop() or because commands came too late, it continues from there and says so in its answer. \pre
  /// finite, and within the limits the device was built for \param dt time that the motion has taken since
  /// the last setpoint. Unit: [s].
  virtual MotionAnswer move(const MotionSetpoint& motion, double dt) = 0;
  virtual void wait(const LoopClock& clock, double until) { clock.sleep_until(until); }
  /// @}

  /// Brakes each joint as fast as its limits permit; the next move() continues from there. From any thread,
  /// also a signal handler.
  virtual void stop() noexcept {}
};

}  // namespace palpate
