/// \file
/// Safety governor of a haptic device: every wrench from a force model passes it on the way to the motors.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_capabilities.h>
#include <palpate/servo/device_pose.h>
#include <palpate/servo/fault.h>
#include <palpate/servo/lateness.h>
#include <palpate/servo/sustained_limit.h>

namespace palpate {

/// Reading of a device at one instant.
struct DeviceReading {
  double t = 0.0;   ///< when it was measured, on the loop's clock. Unit: [s].
  DevicePose pose;  ///< X_DH: of the handle H, in the frame D of the device
  Twist velocity;   ///< V_DH: of H, measured and expressed in D
  /// Changes if another hand holds the handle, or the device was disconnected: the handle may then be
  /// anywhere.
  std::uint32_t hand = 0;
  std::uint32_t buttons = 0;  ///< one bit each, set while pressed; the lowest bit is the first button
  /// F_H_D: wrench of the hand on the handle, if the device measures it; torque about the origin of H,
  /// expressed in D.
  std::optional<Wrench> user = {};
};

/// Safety limits. The defaults suit a hand on any commercial desktop device.
struct SafetyLimits {
  double force_max = 0.0;   ///< Unit: [N]. > 0
  double torque_max = 0.0;  ///< Unit: [N m]. >= 0
  /// Sustained limits over SustainedLimit::kTime; 0 = equal to the peak. Unit: [N], [N m].
  double force_sustained = 0.0, torque_sustained = 0.0;
  /// Slew rate limits of the wrench; by default from zero to the peak in kSlewTime. Unit: [N/s], [N m/s].
  double force_slew = 0.0, torque_slew = 0.0;
  double tick = 1e-3;            ///< nominal time between calls. Unit: [s]. > 0
  double reading_period = 1e-3;  ///< nominal time between readings of the device. Unit: [s]. > 0

  double gate_share =
      0.05;  ///< fraction of force_max and torque_max: a wrench below both opens the start gate
  double gate_time = 0.05;  ///< time below both. Unit: [s].
  double rise_time = 0.5;   ///< ramp from the gate to full force. Unit: [s].

  double stale_after = 0.02;  ///< or three reading periods of a slower device. Unit: [s].
  /// Accumulated lateness that is tolerated: for each tick, the time beyond two periods since the last one.
  /// It decays by a tenth of the elapsed time. Unit: [s].
  double late_max = 0.02;
  /// No hand keeps all six encoder counts constant for so long, but dry friction may: the force then fades
  /// within fade_time, until the pose changes. Unit: [s].
  double frozen_after = 5.0, fade_time = 2.0;
  double contacts_after = 0.2;        ///< Unit: [s].
  double recover_after = 0.25;        ///< Unit: [s].
  double speed_max = 3.0;             ///< Unit: [m/s]. A quick stroke in contact reaches 1 m/s.
  double angular_speed_max = 40;      ///< Unit: [rad/s].
  double jump_speed = 10.0;           ///< speed between two readings that no hand reaches. Unit: [m/s].
  double jump_angular_speed = 150.0;  ///< likewise. Unit: [rad/s].
  double noise = 2e-3;                ///< of positions: displacement not counted as motion. Unit: [m].
  double angular_noise = 0.05;        ///< Unit: [rad].
  double energy_max = 0.05;           ///< largest net energy output. Unit: [J].
  double energy_leak =
      0.1;  ///< decay of the net output: what a sampled spring may supply to a fast-moving hand. Unit: [W].
  /// Upper bound of the energy credited to the hand: at least the work of crossing the workspace, or the
  /// range visited so far, twice against the full force. Unit: [J].
  double energy_reserve = 0.5;

  /// Time from zero to force_max at the default slew rate. Unit: [s].
  static constexpr double kSlewTime = 0.01;

  static SafetyLimits of(const DeviceCapabilities& device, double tick);
};

/// States of a SafetyGovernor.
enum class GovernorState : std::uint8_t {
  kWaiting,  ///< start gate: no force until the requested wrench is small, as the tool may start inside an
             ///< object
  kRising,   ///< ramps up to the requested wrench
  kActive,   ///< the requested wrench, within limits
  kFalling,  ///< fault: the force ramps to zero
  kStopped,  ///< fault: no force
};
std::string_view to_string(GovernorState state);

/// A state transition and its cause.
struct GovernorTransition {
  double t = 0.0;  ///< Unit: [s].
  GovernorState to = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
};

/// Stands between a force model and a device. Whatever the input, the wrench sent is
///
///  - finite, at most force_max and torque_max, in the requested direction; on average over
///    SustainedLimit::kTime, at most the sustained limits;
///  - limited in slew: no farther from the previous output than the slew rate permits in the elapsed time, or
///    in two ticks if that is less; a fall instead ramps linearly to zero;
///  - zero while the state is kWaiting or kStopped, and within FaultTraits::fall_time of every fault. Faults
///    compose: while any is present the force never rises, and it is zero within the shortest of their fall
///    times.
///
/// All bounds refer to elapsed time, not to a number of ticks. One thread calls, once per tick and in this
/// order: admit() with the reading of the device, then the force model with reading(), then release() with
/// the wrench the model requests. Any thread, or a signal handler, may call stop(), resume() and unpause().
/// Does not allocate, lock or throw.
///
///     kWaiting --small for gate_time--> kRising --rise_time--> kActive
///         any state --fault--> kFalling --fall_time--> kStopped
///         kStopped --no fault for recover_after, latched ones resumed--> kWaiting
class SafetyGovernor {
 public:
  explicit SafetyGovernor(const SafetyLimits& limits);

  /// Takes the newest reading, at the time `t` of the tick; the previous one again if there is no new one.
  /// \returns true if it is valid and new. \pre `t` never decreases.
  bool admit(const DeviceReading& reading, double t);
  /// The same while the device has not sent any reading yet.
  void admit_none(double t);

  /// The last valid reading, the only one that force models see.
  const DeviceReading& reading() const { return reading_; }

  /// Returns the wrench to send, F_H_D. \param wanted wrench that the model requests, likewise F_H_D \param
  /// contacts_age age of the contacts it is based on. Unit: [s]. \param is_known ForceOutput::is_known: if
  /// not, the gate stays shut
  Wrench release(const Wrench& wanted, double contacts_age, bool is_known = true);

  /// Raises the fault `why` on request: if it latches, the force falls and stays zero until resume(). From
  /// any thread, also a signal handler.
  void stop(Fault why = Fault::kEmergencyStop) {
    stop_asked_.fetch_or(fault_bit(why), std::memory_order_relaxed);
  }
  /// Clears latched faults: the force returns through the start gate if their cause is gone. Faults raised in
  /// the same tick remain. From any thread, also a signal handler. Ordered before what that thread loads
  /// afterwards, so that it can find out whether it came too late.
  void resume() { resume_asked_.store(true, std::memory_order_seq_cst); }
  /// Clears stop(Fault::kPaused) and no other fault. From any thread, also a signal handler.
  void unpause() { unpause_asked_.store(true, std::memory_order_relaxed); }

  /// Fraction of the wrench last requested of release() that is let through once slew has settled; 0 in a
  /// fall. In [0, 1].
  double force_scale() const { return force_scale_; }

  /// Whether it was paused and not resumed since, also if another fault is reported.
  bool is_paused() const { return (held_ & fault_bit(Fault::kPaused)) != 0U; }

  GovernorState state() const { return state_; }
  /// Reason for withholding force; kNone if there is none.
  Fault fault() const { return fault_; }
  /// The last state transitions, oldest first, at most kRemembered.
  std::span<const GovernorTransition> transitions() const { return {transitions_.data(), remembered_}; }
  /// Number of transitions in all.
  std::size_t transition_count() const { return transition_count_; }
  static constexpr std::size_t kRemembered = 64;

  /// Net energy that the device has delivered to the hand: positive if it is active. The energy credited to
  /// the hand is bounded by SafetyLimits::energy_reserve. Unit: [J].
  double energy() const { return energy_; }

 private:
  /// Speed bound tolerant of noise and slightly late readings: a token bucket of permitted travel that fills
  /// with time.
  struct SpeedBound {
    double speed, noise;
    double left = 0.0;
    /// \param dt since the last reading \param period nominal time between readings \returns false if the
    /// travel `way` exceeds the content of the bucket.
    bool take(double way, double dt, double period);
  };

  void begin_tick(double t);
  /// Returns the first fault of a reading, kNone if it has none.
  Fault check(const DeviceReading& reading);
  void watch_energy(const DevicePose& from, const DevicePose& to, double dt);
  void watch_rate(bool fresh);
  void watch_stillness(bool moved);
  void raise(Fault fault);
  void hear();
  /// Clears latched faults.
  void forgive(unsigned faults);
  bool holds(Fault fault) const;
  void enter(GovernorState state);
  void remember();
  /// Leaves the state if its time is over. \param small the requested wrench is below the gate threshold
  void advance(bool small);
  double share() const;

  SafetyLimits limits_;
  GovernorState state_ = GovernorState::kWaiting;
  Fault fault_ = Fault::kNone;
  double t_ = 0.0, since_ = 0.0;  ///< now, and time of entry into the state. Unit: [s].
  double passed_ = 0.0;           ///< since the last tick. Unit: [s].
  Lateness lateness_;
  bool asked_ = false;        ///< a reading was admitted in this state: the requested wrench answers one
  double small_since_ = 0.0;  ///< since when the requested wrench is below the gate threshold. Unit: [s].
  double wrong_at_ = 0.0;     ///< time of the last fault. Unit: [s].
  bool begun_ = false;        ///< admit() was called
  bool started_ = false;      ///< a reading was received
  unsigned held_ = 0;         ///< latched faults not yet resumed, one bit each
  SpeedBound jump_, quick_, angular_jump_, angular_quick_;
  DeviceReading newest_;   ///< newest with a well-formed pose
  DeviceReading reading_;  ///< newest valid one
  double arrived_ = 0.0;   ///< arrival of the last new reading. Unit: [s].
  double moved_ = 0.0;     ///< when the pose last changed, or no force was requested. Unit: [s].
  double fade_ = 1.0;      ///< remaining fraction of the force while the pose is frozen
  bool presses_ = false;   ///< the requested wrench is above the gate threshold
  double fresh_ = 1.0;     ///< fraction of the time covered by new readings, filtered
  double energy_ = 0.0;
  Eigen::AlignedBox3d reach_;  ///< range of the handle so far, in D. Unit: [m].
  Wrench sent_;
  double force_scale_ = 0.0;
  SustainedLimit force_, torque_;            ///< of the wrench sent
  Wrench at_fall_;                           ///< wrench sent at fall_from_
  double fall_from_ = 0.0, fall_end_ = 0.0;  ///< linear ramp to zero. Unit: [s].
  std::atomic<unsigned> stop_asked_ = 0;     ///< one bit for every Fault
  std::atomic<bool> resume_asked_ = false, unpause_asked_ = false;
  std::array<GovernorTransition, kRemembered> transitions_;
  std::size_t remembered_ = 0, transition_count_ = 0;
};

}  // namespace palpate
