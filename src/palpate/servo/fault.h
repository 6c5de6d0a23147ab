/// \file
/// Faults of a servo loop and their handling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace palpate {

/// Reason for withholding force. Recordings store the numbers: append new faults at the end.
enum class Fault : std::uint8_t {
  kNone,
  kBadPose,        ///< a reading with NaN, infinity or an invalid quaternion
  kStalePose,      ///< no new reading for SafetyLimits::stale_after, or outdated ones
  kFrozenPose,     ///< the same pose to the last bit, under force, for SafetyLimits::frozen_after
  kJump,           ///< two consecutive readings farther apart than a hand can move
  kOverSpeed,      ///< faster than SafetyLimits::speed_max
  kBadForce,       ///< a force model returned NaN or infinity
  kLateContacts,   ///< the contacts are older than SafetyLimits::contacts_after
  kOverEnergy,     ///< the net energy output of the device exceeds SafetyLimits::energy_max
  kSlowDevice,     ///< readings come at less than half of DeviceCapabilities::rate
  kChanging,       ///< the model or the workspace is being changed
  kPaused,         ///< the force was paused on request
  kRecorder,       ///< recording failed; the data of the run would be lost
  kEmergencyStop,  ///< the emergency stop was pressed
  kLateTick,       ///< the loop's ticks are too late: SafetyLimits::late_max
  kCrowded,        ///< the model needs more contacts than fit in a tick: ToolTracker::kMost
  kStalled,        ///< the loop did not tick for ServoLoop::kPatience; the device was stopped
  kForceSensor,    ///< implausible or missing force measurements: ForceSensorGuard
  kNotFollowing,   ///< following error above MotionSafety::following_max
  kEnded,          ///< the loop or the program is being stopped
};
inline constexpr std::size_t kFaultCount = 20;

/// Properties of a fault.
struct FaultTraits {
  std::string_view name;    ///< as used in files and on the wire
  std::string_view advice;  ///< remedy, for a person
  /// Time from the tick that detects the fault until the force is zero; 0 = within that tick. Unit: [s].
  double fall_time;
  /// True if the force stays off until SafetyGovernor::resume(); otherwise it returns by itself, through the
  /// start gate, once the cause has been absent for SafetyLimits::recover_after.
  bool latched;
  /// True if the force was stopped on request and nothing has failed.
  bool requested = false;
};

const FaultTraits& traits(Fault fault);

/// The bit of a fault in a set of faults.
constexpr unsigned fault_bit(Fault fault) { return 1U << static_cast<unsigned>(fault); }

}  // namespace palpate
