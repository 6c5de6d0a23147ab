/// \file
/// The only way from an admittance controller to a device: what SafetyGovernor is for a wrench.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/servo/fault.h>
#include <palpate/servo/force_sensor_guard.h>
#include <palpate/servo/motion_device.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

/// What is allowed.
struct MotionSafety {
  double tick = 1e-3;                          ///< between calls, as planned. Unit: [s]. > 0
  double reading_period = 1e-3;                ///< as the device promises. Unit: [s]. > 0
  double gate_force = 2.0, gate_torque = 0.2;  ///< of the hand, below which the gate opens. Unit: [N], [N m].
  double gate_time = 0.25;                     ///< for as long. Unit: [s].
  double rise_time = 0.5;       ///< from the gate until all of the force moves the handle. Unit: [s].
  double stale_after = 0.02;    ///< or three readings. Unit: [s].
  double late_max = 0.02;       ///< as SafetyLimits::late_max
  double recover_after = 0.25;  ///< Unit: [s].
  double speed_max = 1.8, angular_speed_max = 4.5;  ///< as measured. Unit: [m/s], [rad/s].
  double jump = 0.05, angular_jump = 0.2;  ///< between two readings, beyond the fastest. Unit: [m], [rad].
  double following_max = 0.1, angular_following_max = 0.35;  ///< see Fault::kNotFollowing. Unit: [m], [rad].
  ForceSensorLimits sensor;

  static MotionSafety of(const DeviceCapabilities& device, const MotionLimits& limits, double tick);
};

/// Stands between an admittance controller and a device. Whatever goes in,
///
///  - the controller gets forces that are finite, and that a hand can exert; none before the gate has opened;
///  - a fault brakes: the handle is at rest within MotionLimits::stop_time() and stays there. Each fault that
///    does not latch is over once nothing has been wrong for recover_after; then the hand's force must be
///    small for gate_time, and moves the handle by a share that grows from nothing in rise_time;
///  - at the first gate what the sensor says is its bias, so nobody must hold the handle; later gates go by
///    that bias, until tare().
///
/// One thread calls, once a tick: admit(), then the controller with user() and share(), or its brake() where
/// brakes(), then moved(). Any thread, or a signal handler, may call stop(), resume(), unpause() and tare().
/// Takes nothing from the heap, locks nothing, throws nothing.
///
///     kWaiting --hand's force small for gate_time--> kRising --rise_time--> kActive
///         any state --fault--> kFalling (brakes) --at rest--> kStopped
///         kStopped --all gone for recover_after, and those that latch resumed--> kWaiting
class MotionGovernor {
 public:
  explicit MotionGovernor(const MotionSafety& safety);

  /// Takes the newest reading, at the time `t` of the tick; the same one again where none has come.
  /// \pre `t` never falls.
  void admit(const MotionReading& reading, double t);
  /// The same where the device has not said anything yet.
  void admit_none(double t);

  /// The last reading that was good.
  const MotionReading& reading() const { return reading_; }
  /// Of the hand, without the sensor's bias. Device's frame.
  Wrench user() const { return sensor_.wrench(); }
  /// Of all forces, what moves the handle in this tick, in [0, 1].
  double share() const;
  /// The controller brakes in this tick, and does not step.
  bool brakes() const {
    return state_ == GovernorState::kFalling || state_ == GovernorState::kStopped || share() == 0.0;
  }

  /// What the controller and the device have made of it. \param wanted is sent as it is if it is finite
  /// \returns false where it is not: the device stays where it was told to be. \param at_rest the motion has
  /// come to its end
  bool moved(const MotionSetpoint& wanted, const MotionSetpoint& followed, bool at_rest);

  /// As those of SafetyGovernor.
  void stop(Fault why = Fault::kEmergencyStop) {
    stop_asked_.fetch_or(1U << static_cast<unsigned>(why), std::memory_order_relaxed);
  }
  void resume() { resume_asked_.store(true, std::memory_order_relaxed); }
  void unpause() { unpause_asked_.store(true, std::memory_order_relaxed); }
  /// Nobody holds the handle: what the sensor says at the next gate is its bias.
  void tare() { tare_asked_.store(true, std::memory_order_relaxed); }

  GovernorState state() const { return state_; }
  Fault fault() const { return fault_; }
  SensorFault sensor_fault() const { return sensor_fault_; }  ///< of the last Fault::kForceSensor
  const Wrench& bias() const { return sensor_.bias(); }
  /// The last changes of state, oldest first, at most SafetyGovernor::kRemembered.
  std::span<const GovernorTransition> transitions() const { return {transitions_.data(), remembered_}; }

 private:
  void begin_tick(double t);
  void hear();
  Fault check(const MotionReading& reading) const;
  void listen_to_sensor(const MotionReading& reading);
  void raise(Fault fault);
  void enter(GovernorState state);
  bool small() const;
  void advance();

  MotionSafety safety_;
  ForceSensorGuard sensor_;
  GovernorState state_ = GovernorState::kWaiting;
  Fault fault_ = Fault::kNone;
  SensorFault sensor_fault_ = SensorFault::kNone;
  double t_ = 0.0, since_ = 0.0, passed_ = 0.0, late_ = 0.0;
  double small_since_ = 0.0, wrong_at_ = 0.0, arrived_ = 0.0;
  bool begun_ = false, started_ = false, tared_ = false, at_rest_ = true, heard_sensor_ = false;
  unsigned held_ = 0;  ///< latched faults that nobody has resumed, a bit each
  MotionReading newest_, reading_;
  std::atomic<unsigned> stop_asked_ = 0;
  std::atomic<bool> resume_asked_ = false, unpause_asked_ = false, tare_asked_ = false;
  std::array<GovernorTransition, SafetyGovernor::kRemembered> transitions_;
  std::size_t remembered_ = 0;
};

}  // namespace palpate
