/// \file
/// One tick of the loop between a hand and a scene.
#pragma once

#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/servo/haptic_device.h>
#include <palpate/servo/passivity.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

/// What happened in a tick.
struct TickRecord {
  double t = 0.0;            ///< Unit: [s].
  DeviceReading reading;     ///< the last good one
  ForceOutput felt;          ///< of the model, there
  Wrench sent;               ///< what the device was told
  std::size_t contacts = 0;  ///< of the tool; 0 where the model looks for contacts by itself
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
  double excess = 0.0;         ///< PassivityController::excess(). Unit: [J].
  double balance = 0.0;        ///< PassivityController::balance(). Unit: [J].
  double added_damping = 0.0;  ///< Unit: [N s/m].
};

/// Reads the device, asks the force model, keeps that passive and safe, and writes to the device. What drives
/// it tells the time: a thread at 1 kHz, or a test that goes through a minute in a second.
///
/// Used by one thread. run() takes nothing from the heap, locks nothing, throws nothing and logs nothing.
class ServoTick {
 public:
  /// All must outlive it. \param contacts finds what the tool touches, for a model that wants contacts; null
  /// for one that does not \param period between calls of run(). Unit: [s]. > 0
  ServoTick(HapticDevice& device, ForceModel& model, ToolTracker* contacts, double period);

  /// \param t never falls. Unit: [s].
  const TickRecord& run(double t);

  /// For stop(), resume() and the transitions.
  SafetyGovernor& governor() { return governor_; }
  const SafetyGovernor& governor() const { return governor_; }

 private:
  void feel(const DeviceReading& reading);

  HapticDevice& device_;
  ForceModel& model_;
  ToolTracker* contacts_;
  SafetyGovernor governor_;
  PassivityController passivity_;
  DeviceReading said_;
  bool asked_ = false;     ///< the model was, since it was reset
  double asked_at_ = 0.0;  ///< DeviceReading::t of the last time. Unit: [s].
  ContactSet found_;
  Wrench wanted_;
  TickRecord record_;
};

}  // namespace palpate
