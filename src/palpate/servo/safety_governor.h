/// \file
/// The only way from a force model to a motor.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_capabilities.h>
#include <palpate/servo/fault.h>

namespace palpate {

/// What a device says at one instant.
struct DeviceReading {
  double t = 0.0;  ///< when it was measured, on the loop's clock. Unit: [s].
  Pose pose;       ///< of the handle, the device's frame
  Twist velocity;  ///< the same frame
};

/// What is allowed. The defaults fit a hand on any of the devices that are sold for hands.
struct SafetyLimits {
  double force_max = 0.0;   ///< Unit: [N]. > 0
  double torque_max = 0.0;  ///< Unit: [N m]. >= 0
  /// How fast the wrench may change; from nothing to all in kSlewTime by default. Unit: [N/s], [N m/s].
  double force_slew = 0.0, torque_slew = 0.0;
  double tick = 1e-3;            ///< between calls. Unit: [s]. > 0
  double reading_period = 1e-3;  ///< between readings, as the device promises. Unit: [s]. > 0

  double gate_share = 0.05;  ///< of force_max and torque_max: a wrench below both opens the gate
  double gate_time = 0.05;   ///< for as long. Unit: [s].
  double rise_time = 0.5;    ///< from the gate to full force. Unit: [s].

  double stale_after = 0.02;      ///< or three readings of a device that has fewer. Unit: [s].
  double frozen_after = 5.0;      ///< no hand holds still for so long, to a count of six encoders. Unit: [s].
  double contacts_after = 0.2;    ///< Unit: [s].
  double recover_after = 0.25;    ///< Unit: [s].
  double speed_max = 3.0;         ///< Unit: [m/s]. A quick stroke of a hand in contact is at 1 m/s.
  double angular_speed_max = 40;  ///< Unit: [rad/s].
  double jump_speed = 10.0;       ///< that no hand has between two readings. Unit: [m/s].
  double jump_distance = 2e-3;    ///< what may be besides: noise. Unit: [m].
  double jump_turn = 0.5;         ///< Unit: [rad].
  double energy_max = 0.05;       ///< put out beyond what was put in. Unit: [J].
  double energy_leak =
      0.1;  ///< of that forgiven: what a sampled spring gives away to a lively hand. Unit: [W].
  double energy_reserve = 0.5;  ///< of what was put in, the most that is remembered. Unit: [J].

  /// From nothing to force_max.
  static constexpr double kSlewTime = 0.01;

  static SafetyLimits of(const DeviceCapabilities& device, double tick);
};

/// SafetyGovernor's states.
enum class GovernorState : std::uint8_t {
  kWaiting,  ///< no force, until what is asked for is small: the tool may begin inside something
  kRising,   ///< a growing share of what is asked for
  kActive,   ///< all of it, within limits
  kFalling,  ///< a fault: what is left of the force falls to zero
  kStopped,  ///< a fault: no force
};
std::string_view to_string(GovernorState state);

/// A change of state, and why.
struct GovernorTransition {
  double t = 0.0;  ///< Unit: [s].
  GovernorState to = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
};

/// Stands between what a force model asks for and what a device is sent. Whatever goes in, what comes out is
///
///  - finite, at most force_max and torque_max, in the direction that was asked for;
///  - at most a tick's worth of slew from what came out before;
///  - zero while the state is kWaiting or kStopped, and within FaultTraits::fall_time of a fault.
///
/// One thread calls, once a tick and in this order: admit() with what the device says, then the force model
/// with pose(), then release() with what that asks for. Any thread, or a signal handler, may call stop() and
/// resume(). Takes nothing from the heap, locks nothing, throws nothing.
///
///     kWaiting --small for gate_time--> kRising --rise_time--> kActive
///         any state --fault--> kFalling --fall_time--> kStopped --gone for recover_after, or resume()-->
///         kWaiting
class SafetyGovernor {
 public:
  explicit SafetyGovernor(const SafetyLimits& limits);

  /// Takes the newest reading there is, at the time `t` of the tick; the same one again where none has come.
  /// \returns true if it is good and new. \pre `t` never falls.
  bool admit(const DeviceReading& reading, double t);

  /// The last reading that was good. Force models see no other.
  const DeviceReading& reading() const { return reading_; }

  /// What to send, for a model that asks for `wanted`, on contacts that are `contacts_age` old. \param
  /// contacts_age Unit: [s].
  Wrench release(const Wrench& wanted, double contacts_age);

  /// Raises `why`, of its own accord: with a latched fault, no force from the next fall on, until resume().
  /// From any thread, also a signal handler.
  void stop(Fault why = Fault::kEmergencyStop) {
    stop_asked_.fetch_or(1U << static_cast<unsigned>(why), std::memory_order_relaxed);
  }
  /// Lets the force come back after a latched fault, through the gate, if its cause is gone. In the same tick
  /// as an emergency stop, that wins; any other stop() is over at once.
  void resume() { resume_asked_.store(true, std::memory_order_relaxed); }

  GovernorState state() const { return state_; }
  /// Why the force is held back; kNone if it is not.
  Fault fault() const { return fault_; }
  /// The last changes of state, oldest first, at most kRemembered.
  std::span<const GovernorTransition> transitions() const { return {transitions_.data(), remembered_}; }
  /// How many there were in all.
  std::size_t transition_count() const { return transition_count_; }
  static constexpr std::size_t kRemembered = 64;

  /// Net energy that the device has put into the hand: positive if it is active. Never below -energy_reserve.
  /// Unit: [J].
  double energy() const { return energy_; }

 private:
  /// The first thing that is wrong with a reading, kNone if nothing is.
  Fault check(const DeviceReading& reading) const;
  void watch_energy(const Pose& from, const Pose& to, double dt);
  void watch_rate(bool fresh);
  void raise(Fault fault);
  void hear();
  void enter(GovernorState state);
  void remember();
  /// Moves on from the state if its time has come. \param small what is asked for is below the gate
  void advance(bool small);
  double share() const;

  SafetyLimits limits_;
  GovernorState state_ = GovernorState::kWaiting;
  Fault fault_ = Fault::kNone;
  double t_ = 0.0, since_ = 0.0;  ///< now, and when the state was entered. Unit: [s].
  double small_since_ = 0.0;      ///< since when what is asked for is below the gate. Unit: [s].
  double wrong_at_ = 0.0;         ///< when something was wrong last. Unit: [s].
  bool begun_ = false;            ///< admit() was called
  bool started_ = false;          ///< there was a reading
  bool resumed_ = false;          ///< someone wants the force back
  DeviceReading newest_;          ///< that was a pose at all
  DeviceReading reading_;         ///< that was good
  double arrived_ = 0.0;          ///< when a new reading came last. Unit: [s].
  double moved_ = 0.0;            ///< when the pose changed last, or no force was on. Unit: [s].
  double fresh_ = 1.0;            ///< share of the promised readings that come, filtered
  double energy_ = 0.0;
  Wrench sent_;
  Wrench at_fall_;                        ///< what was sent when the fall began
  std::atomic<unsigned> stop_asked_ = 0;  ///< a bit for every Fault
  std::atomic<bool> resume_asked_ = false;
  std::array<GovernorTransition, kRemembered> transitions_;
  std::size_t remembered_ = 0, transition_count_ = 0;
};

}  // namespace palpate
