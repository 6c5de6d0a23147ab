/// \file
/// The only way from a force model to a motor.
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
#include <palpate/servo/sustained_limit.h>

namespace palpate {

/// What a device says at one instant.
struct DeviceReading {
  double t = 0.0;   ///< when it was measured, on the loop's clock. Unit: [s].
  DevicePose pose;  ///< X_DH: of the handle H, in the frame D of the device
  Twist velocity;   ///< V_DH: of H, measured and expressed in D
  /// Another number: another hand has the handle, or the device was away, and the handle may be anywhere.
  std::uint32_t hand = 0;
  std::uint32_t buttons = 0;  ///< a bit each, set while it is pressed; the lowest is the first
  /// F_H_D: of the hand on the handle, where the device measures it; torque about the origin of H, expressed
  /// in D.
  std::optional<Wrench> user = {};
};

/// What is allowed. The defaults fit a hand on any of the devices that are sold for hands.
struct SafetyLimits {
  double force_max = 0.0;   ///< Unit: [N]. > 0
  double torque_max = 0.0;  ///< Unit: [N m]. >= 0
  /// Kept over SustainedLimit::kTime; 0: as much as the peak. Unit: [N], [N m].
  double force_sustained = 0.0, torque_sustained = 0.0;
  /// How fast the wrench may change; from nothing to all in kSlewTime by default. Unit: [N/s], [N m/s].
  double force_slew = 0.0, torque_slew = 0.0;
  double tick = 1e-3;            ///< between calls, as planned. Unit: [s]. > 0
  double reading_period = 1e-3;  ///< between readings, as the device promises. Unit: [s]. > 0

  double gate_share = 0.05;  ///< of force_max and torque_max: a wrench below both opens the gate
  double gate_time = 0.05;   ///< for as long. Unit: [s].
  double rise_time = 0.5;    ///< from the gate to full force. Unit: [s].

  double stale_after = 0.02;  ///< or three readings of a device that has fewer. Unit: [s].
  /// By how much ticks may be late, together: what each comes later than two ticks after the last one. A
  /// tenth of the time that passes is forgiven. Unit: [s].
  double late_max = 0.02;
  /// No hand holds still for so long, to a count of six encoders, but dry friction may hold one: then the
  /// force fades, within fade_time, until the pose changes. Unit: [s].
  double frozen_after = 5.0, fade_time = 2.0;
  double contacts_after = 0.2;        ///< Unit: [s].
  double recover_after = 0.25;        ///< Unit: [s].
  double speed_max = 3.0;             ///< Unit: [m/s]. A quick stroke of a hand in contact is at 1 m/s.
  double angular_speed_max = 40;      ///< Unit: [rad/s].
  double jump_speed = 10.0;           ///< that no hand has between two readings. Unit: [m/s].
  double jump_angular_speed = 150.0;  ///< likewise. Unit: [rad/s].
  double noise = 2e-3;                ///< of positions: a way that is no motion. Unit: [m].
  double angular_noise = 0.05;        ///< Unit: [rad].
  double energy_max = 0.05;           ///< put out beyond what was put in. Unit: [J].
  double energy_leak =
      0.1;  ///< of that forgiven: what a sampled spring gives away to a lively hand. Unit: [W].
  /// Of what was put in, the most that is remembered: at least what a hand puts in that crosses the
  /// workspace, or where it has been, twice against all of the force. Unit: [J].
  double energy_reserve = 0.5;

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
///  - finite, at most force_max and torque_max, in the direction that was asked for; on average over
///    SustainedLimit::kTime, at most what the motors hold for ever;
///  - no farther from what came out before than slew makes in the time since, or in two ticks; but a fall
///    goes straight to its end;
///  - zero while the state is kWaiting or kStopped, and within FaultTraits::fall_time of every fault. Faults
///    compose: while one holds, the force never rises, and it is zero in the shortest time that any asks for.
///
/// All bounds are of the time that has passed, not of a number of ticks. One thread calls, once a tick and in
/// this order: admit() with what the device says, then the force model with reading(), then release() with
/// what that asks for. Any thread, or a signal handler, may call stop(), resume() and unpause(). Takes
/// nothing from the heap, locks nothing, throws nothing.
///
///     kWaiting --small for gate_time--> kRising --rise_time--> kActive
///         any state --fault--> kFalling --fall_time--> kStopped
///         kStopped --all gone for recover_after, and those that latch resumed--> kWaiting
class SafetyGovernor {
 public:
  explicit SafetyGovernor(const SafetyLimits& limits);

  /// Takes the newest reading there is, at the time `t` of the tick; the same one again where none has come.
  /// \returns true if it is good and new. \pre `t` never falls.
  bool admit(const DeviceReading& reading, double t);
  /// The same where the device has not said anything yet.
  void admit_none(double t);

  /// The last reading that was good. Force models see no other.
  const DeviceReading& reading() const { return reading_; }

  /// What to send, F_H_D, for a model that asks for `wanted`, likewise, on contacts that are `contacts_age`
  /// old. Unit: [s].
  Wrench release(const Wrench& wanted, double contacts_age);

  /// Raises `why`, of its own accord: with a latched fault, no force from the next fall on, until resume().
  /// From any thread, also a signal handler.
  void stop(Fault why = Fault::kEmergencyStop) {
    stop_asked_.fetch_or(1U << static_cast<unsigned>(why), std::memory_order_relaxed);
  }
  /// Lets the force come back after latched faults, through the gate, if their cause is gone. What is raised
  /// in the same tick holds. From any thread, also a signal handler.
  void resume() { resume_asked_.store(true, std::memory_order_relaxed); }
  /// Takes back stop(Fault::kPaused), and nothing else. Likewise.
  void unpause() { unpause_asked_.store(true, std::memory_order_relaxed); }

  /// What share of what release() was asked for last goes through by and by: none in a fall. In [0, 1].
  double let_through() const { return let_through_; }

  GovernorState state() const { return state_; }
  /// Why the force is held back; kNone if it is not.
  Fault fault() const { return fault_; }
  /// The last changes of state, oldest first, at most kRemembered.
  std::span<const GovernorTransition> transitions() const { return {transitions_.data(), remembered_}; }
  /// How many there were in all.
  std::size_t transition_count() const { return transition_count_; }
  static constexpr std::size_t kRemembered = 64;

  /// Net energy that the device has put into the hand: positive if it is active. Of what the hand has put in,
  /// no more is remembered than SafetyLimits::energy_reserve. Unit: [J].
  double energy() const { return energy_; }

 private:
  /// The fastest that something moves, of which a reading may be more by noise or because it came a little
  /// late: a bucket that holds what may be moved, and fills as time passes.
  struct SpeedBound {
    double speed, noise;
    double left = 0.0;
    /// \param dt since the last reading, \param period between readings, as promised. \returns false for a
    /// way that is longer than there is room for.
    bool take(double way, double dt, double period);
  };

  void begin_tick(double t);
  /// The first thing that is wrong with a reading, kNone if nothing is.
  Fault check(const DeviceReading& reading);
  void watch_energy(const DevicePose& from, const DevicePose& to, double dt);
  void watch_rate(bool fresh);
  void watch_lateness();
  void watch_stillness(bool moved);
  void raise(Fault fault);
  void hear();
  /// Latched faults that hold no longer.
  void forgive(unsigned faults);
  bool holds(Fault fault) const;
  void enter(GovernorState state);
  void remember();
  /// Moves on from the state if its time has come. \param small what is asked for is below the gate
  void advance(bool small);
  double share() const;

  SafetyLimits limits_;
  GovernorState state_ = GovernorState::kWaiting;
  Fault fault_ = Fault::kNone;
  double t_ = 0.0, since_ = 0.0;  ///< now, and when the state was entered. Unit: [s].
  double passed_ = 0.0;           ///< since the last tick. Unit: [s].
  double late_ = 0.0;             ///< see SafetyLimits::late_max. Unit: [s].
  double small_since_ = 0.0;      ///< since when what is asked for is below the gate. Unit: [s].
  double wrong_at_ = 0.0;         ///< when something was wrong last. Unit: [s].
  bool begun_ = false;            ///< admit() was called
  bool started_ = false;          ///< there was a reading
  unsigned held_ = 0;             ///< latched faults that nobody has resumed, a bit each
  SpeedBound jump_, quick_, angular_jump_, angular_quick_;
  DeviceReading newest_;   ///< that was a pose at all
  DeviceReading reading_;  ///< that was good
  double arrived_ = 0.0;   ///< when a new reading came last. Unit: [s].
  double moved_ = 0.0;     ///< when the pose changed last, or no force was asked for. Unit: [s].
  double fade_ = 1.0;      ///< what is left of the force where nothing moves
  bool presses_ = false;   ///< more is asked for than the gate lets pass
  double fresh_ = 1.0;     ///< share of the time that new readings speak for, filtered
  double energy_ = 0.0;
  Eigen::AlignedBox3d reach_;  ///< where the handle has been, in D. Unit: [m].
  Wrench sent_;
  double let_through_ = 0.0;
  SustainedLimit force_, torque_;            ///< of what is sent
  Wrench at_fall_;                           ///< what was sent at fall_from_
  double fall_from_ = 0.0, fall_end_ = 0.0;  ///< a straight line to zero. Unit: [s].
  std::atomic<unsigned> stop_asked_ = 0;     ///< a bit for every Fault
  std::atomic<bool> resume_asked_ = false, unpause_asked_ = false;
  std::array<GovernorTransition, kRemembered> transitions_;
  std::size_t remembered_ = 0, transition_count_ = 0;
};

}  // namespace palpate
