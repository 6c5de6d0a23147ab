/// \file
/// What can go wrong in a live loop, and what is done about it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace palpate {

/// Why force is held back. Earlier recordings have the numbers: new ones go to the end.
enum class Fault : std::uint8_t {
  kNone,
  kBadPose,        ///< a reading with NaN, infinity, or a quaternion that is no rotation
  kStalePose,      ///< no new reading for SafetyLimits::stale_after, or old ones again
  kFrozenPose,     ///< the same pose to the last bit, under force, for SafetyLimits::frozen_after
  kJump,           ///< two readings farther apart than a hand can move between them
  kOverSpeed,      ///< faster than SafetyLimits::speed_max
  kBadForce,       ///< a model asked for NaN or infinity
  kLateContacts,   ///< the contacts are older than SafetyLimits::contacts_after
  kOverEnergy,     ///< the device has put out more than SafetyLimits::energy_max
  kSlowDevice,     ///< readings come at less than half of DeviceCapabilities::rate
  kChanging,       ///< the model or the workspace is being changed
  kPaused,         ///< someone wants no force for a while
  kRecorder,       ///< the recording failed, and what is felt would be lost
  kEmergencyStop,  ///< someone pressed it
  kLateTick,       ///< the loop's ticks come too late: SafetyLimits::late_max
  kCrowded,        ///< the model wants more contacts than a tick has time for: ToolTracker::kMost
  kStalled,        ///< the loop did not tick for ServoLoop::kPatience, and the device was stopped
  kForceSensor,    ///< the force sensor says what no hand can do, or nothing: ForceSensorGuard
  kNotFollowing,   ///< the device is not where its motion was to take it: MotionSafety::following_max
};
inline constexpr std::size_t kFaultCount = 19;

/// What is known of a fault.
struct FaultTraits {
  std::string_view name;    ///< as in files and on the wire
  std::string_view advice;  ///< what to do about it
  /// From the tick that sees it, the force is zero within this time; 0: in that tick. Unit: [s].
  double fall_time;
  /// True if the force stays off until someone says SafetyGovernor::resume(); else it comes back by itself,
  /// through the gate, once the cause has been gone for SafetyLimits::recover_after.
  bool latched;
};

const FaultTraits& traits(Fault fault);

}  // namespace palpate
