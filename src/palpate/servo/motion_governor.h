/// \file
/// Safety governor of an admittance-type device: the counterpart of SafetyGovernor for motion.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/servo/fault.h>
#include <palpate/servo/force_sensor_guard.h>
#include <palpate/servo/lateness.h>
#include <palpate/servo/motion_device.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

/// Safety limits of an admittance-type device.
struct MotionSafety {
  double tick = 1e-3;            ///< between calls, as planned. Unit: [s]. > 0
  double reading_period = 1e-3;  ///< nominal, of the device. Unit: [s]. > 0
  double gate_force = 2.0,
         gate_torque = 0.2;     ///< of the hand, below which the start gate opens. Unit: [N], [N m].
  double gate_time = 0.25;      ///< time below these thresholds. Unit: [s].
  double rise_time = 0.5;       ///< ramp from the gate to full effect of the force. Unit: [s].
  double stale_after = 0.02;    ///< or three readings. Unit: [s].
  double late_max = 0.02;       ///< as SafetyLimits::late_max
  double recover_after = 0.25;  ///< Unit: [s].
  double speed_max = 1.8, angular_speed_max = 4.5;  ///< as measured. Unit: [m/s], [rad/s].
  double jump = 0.05,
         angular_jump = 0.2;  ///< between two readings, beyond the fastest motion. Unit: [m], [rad].
  double following_max = 0.1, angular_following_max = 0.35;  ///< see Fault::kNotFollowing. Unit: [m], [rad].
  ForceSensorLimits sensor;

  static MotionSafety of(const DeviceCapabilities& device, const MotionLimits& limits, double tick);
};

/// Stands between an admittance controller and a device. Whatever the input,
///
///  - the controller receives only finite forces that a hand can exert, and none before the gate has opened;
///  - a fault brakes: the handle is at rest within MotionLimits::stop_time() and stays there. A fault that
///    does not latch ends once no fault has occurred for recover_after; then the hand's force must be small
///    for gate_time, and its effect on the handle ramps up from zero within rise_time;
///  - no setpoint is known before the first valid reading, nor while the handle is found elsewhere after a
///    jump or with another hand: see knows_place();
///  - at the first gate the sensor's output is taken as its bias, so nobody must hold the handle; later gates
///    use that bias, until tare().
///
/// One thread calls, once per tick: admit(), then the controller with user() and share(), or its brake() if
/// brakes(), then moved(). Any thread, or a signal handler, may call stop(), resume(), unpause() and tare().
/// Does not allocate, lock or throw.
///
///     kWaiting --hand's force small for gate_time--> kRising --rise_time--> kActive
///         any state --fault--> kFalling (brakes) --at rest--> kStopped
///         kStopped --no fault for recover_after, latched ones resumed--> kWaiting
class MotionGovernor {
 public:
  explicit MotionGovernor(const MotionSafety& safety);

  /// Takes the newest reading, at the time `t` of the tick; the previous one again if there is no new one.
  /// \pre `t` never decreases.
  void admit(const MotionReading& reading, double t);
  /// The same while the device has not sent any reading yet.
  void admit_none(double t);

  /// The last valid reading.
  const MotionReading& reading() const { return reading_; }
  /// False while the setpoint has nothing to do with the place of the handle, and must not be sent: before
  /// the first valid reading, and from a handle found elsewhere (Fault::kJump, or another hand) until the
  /// state is kWaiting. Where admit() makes it true, the controller starts at rest at reading().
  bool knows_place() const { return started_ && !elsewhere_; }
  /// True after a jump or with another hand, until a reading agrees with the one before it: that jump may
  /// have been a false reading, or the setpoint may be elsewhere, and must not be sent meanwhile.
  bool doubts_place() const { return jumped_; }
  /// Wrench of the hand, sensor bias removed. Device's frame.
  Wrench user() const { return sensor_.wrench(); }
  /// Fraction of all forces that takes effect in this tick, in [0, 1].
  double share() const;
  /// True if the controller must brake in this tick instead of stepping.
  bool brakes() const {
    return state_ == GovernorState::kFalling || state_ == GovernorState::kStopped || share() == 0.0;
  }

  /// Reports the motion of controller and device. \param wanted setpoint, sent unchanged if finite \returns
  /// false if it is not: the device then keeps its last setpoint. \param at_rest the motion has come to rest
  bool moved(const MotionSetpoint& wanted, const MotionSetpoint& followed, bool at_rest);

  /// As the functions of SafetyGovernor of these names.
  void stop(Fault why = Fault::kEmergencyStop) {
    stop_asked_.fetch_or(fault_bit(why), std::memory_order_relaxed);
  }
  void resume() { resume_asked_.store(true, std::memory_order_seq_cst); }
  void unpause() { unpause_asked_.store(true, std::memory_order_relaxed); }
  /// Takes the sensor's output at the next gate as its bias. \pre nobody holds the handle
  void tare() { tare_asked_.store(true, std::memory_order_relaxed); }

  GovernorState state() const { return state_; }
  Fault fault() const { return fault_; }
  SensorFault sensor_fault() const { return sensor_fault_; }  ///< cause of the last Fault::kForceSensor
  const Wrench& bias() const { return sensor_.bias(); }
  /// The last state transitions, oldest first, at most SafetyGovernor::kRemembered.
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
  double t_ = 0.0, since_ = 0.0, passed_ = 0.0;
  Lateness lateness_;
  double small_since_ = 0.0, wrong_at_ = 0.0, arrived_ = 0.0, jumped_at_ = 0.0;
  bool moves_on_ = false;   ///< the newest reading agrees with the one before it
  bool jumped_ = false;     ///< no reading has shown yet whether the handle is still at its setpoint
  bool elsewhere_ = false;  ///< it is not
  bool begun_ = false, started_ = false, tared_ = false, at_rest_ = true, heard_sensor_ = false;
  unsigned held_ = 0;  ///< latched faults not yet resumed, one bit each
  MotionReading newest_, reading_;
  std::atomic<unsigned> stop_asked_ = 0;
  std::atomic<bool> resume_asked_ = false, unpause_asked_ = false, tare_asked_ = false;
  std::array<GovernorTransition, SafetyGovernor::kRemembered> transitions_;
  std::size_t remembered_ = 0;
};

}  // namespace palpate
