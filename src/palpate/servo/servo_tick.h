/// \file
/// One tick of the loop between a hand and a scene.
#pragma once

#include <atomic>
#include <limits>
#include <optional>

#include <palpate/base/triple_buffer.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/servo/haptic_device.h>
#include <palpate/servo/passive_gain.h>
#include <palpate/servo/passivity.h>
#include <palpate/servo/safety_governor.h>
#include <palpate/servo/worker.h>
#include <palpate/servo/workspace_map.h>

namespace palpate {

/// What happened in a tick.
struct TickRecord {
  double t = 0.0;         ///< Unit: [s].
  DeviceReading reading;  ///< the last good one, in the device's frame D
  Pose tool;              ///< X_WT: where that is in the world
  Twist velocity;         ///< V_WT
  ForceOutput felt;       ///< of the model, there
  WorkspaceMap map;       ///< that took the reading there
  Wrench sent;            ///< F_H_D: what the device was told, torque about the handle
  Wrench sent_world;      ///< the same along the axes of the world, as large as in the hand
  /// Of the tool, by ServoTick::look(); see ContactSet. Of more than ToolTracker::kMost pairs, those that
  /// come first.
  std::size_t candidates = 0, filtered = 0, contacts = 0;
  double k_max = 0.0;  ///< ContactSet::k_max(), likewise
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
  double energy = 0.0;         ///< SafetyGovernor::energy(). Unit: [J].
  double put_out = 0.0;        ///< PassivityController::put_out(). Unit: [J].
  double added_damping = 0.0;  ///< Unit: [N s/m].
  /// How many times as stiff as it was set the spring might be before it is active (passive_stiffness(), in a
  /// hand that damps by ServoTick::kHandDamping); 0 where there is none, or nothing is known of it. Below 1
  /// the spring is softer than it was set, by that.
  double margin = 0.0;
  double let_through = 0.0;  ///< SafetyGovernor::let_through()
};

/// A force model, and what finds contacts for it.
struct FeltModel {
  ForceModel* model = nullptr;
  ToolTracker* contacts = nullptr;
  const Worker* worker = nullptr;  ///< what looks for contacts ahead of them, watched for delays; null: none
};

/// How a ServoTick is set up.
struct ServoTickOptions {
  double period = 1e-3;  ///< between calls of run(). Unit: [s]. > 0
  WorkspaceMap map;
  double gain = 1.0;  ///< what all of the model's forces are multiplied with. >= 0
  /// In place of SafetyLimits::of() the device, for trials in virtual time of what would not be let near a
  /// hand.
  std::optional<SafetyLimits> limits;
  /// False, likewise: springs stay as stiff as they are set, however late the force.
  bool keeps_passive = true;
};

/// Reads the device, asks the force model, keeps that passive and safe, and writes to the device. What drives
/// it tells the time: a thread at 1 kHz, or a test that goes through a minute in a second.
///
/// run() is used by one thread, and takes nothing from the heap, locks nothing, throws nothing and logs
/// nothing. What other threads may call says so.
class ServoTick {
 public:
  /// All must outlive it.
  ServoTick(HapticDevice& device, FeltModel model, const ServoTickOptions& options = {});

  /// From reading to force. \param t never falls. Unit: [s].
  const TickRecord& run(double t);

  /// What the tool touches where run() had it, for whoever looks on, once the force is sent. \returns the
  /// record of run(), with it.
  const TickRecord& look();

  /// What any hand that holds on damps by at least, besides the device. Unit: [N s/m].
  static constexpr double kHandDamping = 1.0;

  /// Until it is time for the next tick: HapticDevice::wait().
  void wait(const LoopClock& clock, double until) { device_.wait(clock, until); }

  /// Where the device is in the world now. The thread of run(); devices may ask while they are read.
  const WorkspaceMap& map() const { return map_; }

  /// For stop(), resume() and, on the thread of run(), the transitions.
  SafetyGovernor& governor() { return governor_; }
  const SafetyGovernor& governor() const { return governor_; }

  /// \name From any thread
  /// @{
  /// Once the force has fallen; it comes back through the gate. One thread at a time. What `model` names must
  /// live until another one is_used().
  void use(const FeltModel& model);
  /// True once run() has taken what use() was given last.
  bool is_used() const { return taken_.load(std::memory_order_acquire) == given_; }
  /// The gain goes there within a few tenths of a second, and no work is done by that (PassiveGain).
  void set_gain(double gain) { wanted_gain_.store(gain, std::memory_order_relaxed); }
  double wanted_gain() const { return wanted_gain_.load(std::memory_order_relaxed); }
  /// While it is pressed, the tool keeps its pose and there is no force: the hand can be moved and turned to
  /// where it has room. TickRecord::map is another once it is released.
  void press_clutch(bool pressed);
  /// Has the tool be at `place` once no force is on, with the hand where it is, as if a clutch had been
  /// pressed meanwhile; not if it is within `reach` of it. TickRecord::map is another then. One thread at a
  /// time. \param place X_WT \param reach Unit: [m].
  void bring(const Pose& place, double reach);
  /// run() does not come to an end, or the program is about to: the device is stopped, and whatever run() was
  /// about to write is of no force. Also from a signal handler.
  void stall() {
    governor_.stop(Fault::kStalled);
    device_.stop();
  }
  /// From reading to write(), as measured by who can; counts against the margin, as does what the motors take
  /// after that (DeviceCapabilities::delay). Unit: [s].
  void set_delay(double delay) { delay_.store(delay, std::memory_order_relaxed); }
  /// @}

 private:
  void change(double passed);
  bool listen(double t);
  void place_tool(bool held);
  void feel();
  /// What has been wound up by a turn against a torque that the device does not show. Unit: [J], of the
  /// world.
  double unfelt_work(const Wrench& felt);
  double keep_passive(double stiffness, bool begins);
  void tell();

  HapticDevice& device_;
  FeltModel used_;
  WorkspaceMap map_;
  double gain_;
  PassiveGain passive_gain_;
  SafetyGovernor governor_;
  PassivityController passivity_;
  bool keeps_passive_;
  double held_for_;  ///< a force until the next one, the mean over time. Unit: [s].
  double gain_max_ = std::numeric_limits<double>::infinity();   ///< with which the spring is passive
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();            ///< of the model, last
  Eigen::Quaterniond turned_ = Eigen::Quaterniond::Identity();  ///< the tool, then
  DeviceReading said_;
  bool heard_ = false;  ///< the device has said something
  bool clutched_ = false;
  bool tool_held_ = false;  ///< by the clutch, where it was
  bool asked_ = false;      ///< the model was, since it was reset
  double asked_at_ = 0.0;   ///< DeviceReading::t of the last time. Unit: [s].
  ContactSet found_;
  Wrench wanted_;
  TickRecord record_;

  struct Next {
    FeltModel model;
    std::uint64_t number = 0;  ///< of the calls of use()
  };
  TripleBuffer<Next> next_;
  std::uint64_t given_ = 0;  ///< number of the last of them
  std::atomic<std::uint64_t> taken_ = 0;
  bool changing_ = false;  ///< next_.front() waits until no force is on
  std::atomic<bool> clutch_pressed_ = false;
  struct Place {
    Pose pose;           ///< X_WT
    double reach = 0.0;  ///< Unit: [m].
  };
  TripleBuffer<Place> places_;
  bool brings_ = false;  ///< places_.front() waits until no force is on
  std::atomic<double> wanted_gain_, delay_ = 0.0;
};

}  // namespace palpate
