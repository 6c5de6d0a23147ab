/// \file
/// One tick of the haptic servo loop.
#pragma once

#include <algorithm>
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

/// Record of one tick.
struct TickRecord {
  double t = 0.0;         ///< Unit: [s].
  DeviceReading reading;  ///< the last valid reading, in the device's frame D
  Pose tool;              ///< X_WT: pose of the tool in the world
  Twist velocity;         ///< V_WT
  ForceOutput felt;       ///< output of the force model at that pose
  WorkspaceMap map;       ///< map from device to world that was used
  Wrench sent;            ///< F_H_D: wrench sent to the device, torque about the handle
  Wrench sent_world;      ///< the same, not scaled, expressed in the world
  /// Contact counts of the tool, set by ServoTick::count_contacts(); see ContactSet. Covers the first
  /// ToolTracker::kMost pairs.
  std::size_t candidates = 0, filtered = 0, contacts = 0;
  double k_max = 0.0;  ///< ContactSet::k_max(), likewise
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
  double energy = 0.0;         ///< SafetyGovernor::energy(). Unit: [J].
  double port_energy = 0.0;    ///< PassivityController::port_energy(). Unit: [J].
  double added_damping = 0.0;  ///< Unit: [N s/m].
  /// Stiffness margin: ratio of the largest passive stiffness (ServoTick::passive_stiffness()) to the set
  /// stiffness; 0 if there is no spring or it is unknown. Below 1 the spring is softened by this factor.
  double margin = 0.0;
  double force_scale = 0.0;  ///< SafetyGovernor::force_scale()
  bool paused = false;       ///< SafetyGovernor::is_paused()
};

/// Stiffness along any direction, and about any axis.
struct PassiveStiffness {
  double along = 0.0;  ///< Unit: [N/m].
  double about = 0.0;  ///< Unit: [N m/rad].
};

/// A force model and its contact search.
struct FeltModel {
  ForceModel* model = nullptr;
  ToolTracker* contacts = nullptr;
  const Worker* worker = nullptr;  ///< lookahead search for contacts, whose age is monitored; null = none
};

/// Options of a ServoTick.
struct ServoTickOptions {
  double period = 1e-3;  ///< between calls of run(). Unit: [s]. > 0
  WorkspaceMap map;
  double gain = 1.0;  ///< factor on all forces of the model. >= 0
  /// Overrides SafetyLimits::of() of the device, for trials in virtual time that would be unsafe for a hand.
  std::optional<SafetyLimits> limits;
  /// False, likewise for trials: springs keep the set stiffness, however delayed the force.
  bool keeps_passive = true;
};

/// Reads the device, evaluates the force model, enforces passivity and safety limits, and writes to the
/// device. The caller supplies the time: a thread at 1 kHz, or a test that simulates a minute in a second.
///
/// run() is called by one thread, and does not allocate, lock, throw or log. Functions for other threads are
/// marked as such.
class ServoTick {
 public:
  /// All must outlive it.
  ServoTick(HapticDevice& device, FeltModel model, const ServoTickOptions& options = {});

  /// Runs one tick, from reading to force. \param t never decreases. Unit: [s].
  const TickRecord& run(double t);

  /// Finds the contacts of the tool at its pose in run(), for observers, once the force is sent. \returns the
  /// record of run(), with the contact counts.
  const TickRecord& count_contacts();

  /// Lower bound of the damping of a hand that holds the handle, in addition to the device's: assumed, and
  /// the same about an axis, at a grip of 30 mm. Unit: [N s/m], [N m s/rad].
  static constexpr double kHandDamping = 1.0, kHandAngularDamping = kHandDamping * 0.03 * 0.03;

  /// Lower bound of the mass of handle and hand. A damper B whose force is late by tau moves a mass m to and
  /// fro if B > (pi / 2) m / tau: models may render m / tau. Unit: [kg].
  static constexpr double kHandMass = 0.05;

  /// Largest stiffness of each kind that `device` renders passively in such a hand, without the other;
  /// infinite about axes without actuated rotation. \param held time between forces. Unit: [s]. > 0 \param
  /// delay from reading to write(). Unit: [s].
  static PassiveStiffness passive_stiffness(const DeviceCapabilities& device, double held,
                                            double delay = 0.0);
  /// Longest arm g of a spring of `stiffness` along, and stiffness g^2 about, that uses half of the latter's
  /// bound, or as much of it as of the former's. Unit: [m], of the device.
  static double longest_arm(const DeviceCapabilities& device, double stiffness, double held);

  /// Waits for the next tick: HapticDevice::wait().
  void wait(const LoopClock& clock, double until) { device_.wait(clock, until); }

  /// Before each tick of a loop that is to end: HapticDevice::come_to_rest().
  bool come_to_rest() { return device_.come_to_rest(); }

  /// Current map from device to world. Called by the thread of run(); devices may call it within read().
  const WorkspaceMap& map() const { return map_; }

  /// Access to stop() and resume() and, on the thread of run(), to the transitions.
  SafetyGovernor& governor() { return governor_; }
  const SafetyGovernor& governor() const { return governor_; }

  /// \name From any thread
  /// @{
  /// Replaces the force model. Takes effect after the force has ramped to zero; the start gate then reopens.
  /// One thread at a time. The objects that `model` points to must live until another model is_used().
  void use(const FeltModel& model);
  /// True once run() uses the model last passed to use().
  bool is_used() const { return taken_.load(std::memory_order_acquire) == given_; }
  /// Sets the gain, which is approached within a few tenths of a second without doing work (PassiveGain). Has
  /// no effect if `gain` is negative, which would pull the hand in, or not finite.
  void set_gain(double gain);
  double wanted_gain() const { return wanted_gain_.load(std::memory_order_relaxed); }
  /// Presses or releases the clutch. While it is pressed, the tool keeps its pose and there is no force, so
  /// that the hand can be moved and turned within its workspace. Release changes TickRecord::map.
  void press_clutch(bool pressed);
  bool is_clutch_pressed() const { return clutch_pressed_.load(std::memory_order_relaxed); }
  /// Moves the tool to `place` after the force has ramped to zero, with the hand where it is, as if by the
  /// clutch; does nothing if the tool is within `reach` of it. Changes TickRecord::map. One thread at a time.
  /// \param place X_WT \param reach Unit: [m].
  void bring(const Pose& place, double reach);
  /// Stops the device because run() does not return or the program is about to terminate; a pending write of
  /// run() has no effect. Also from a signal handler.
  void stall() {
    governor_.stop(Fault::kStalled);
    device_.stop();
  }
  /// Sets the measured delay from reading to write(); it reduces the margin, as does the delay of the motors
  /// (DeviceCapabilities::delay). Below zero, as of readings from a clock that is ahead, it counts as none.
  /// Unit: [s].
  void set_delay(double delay) { delay_.store(std::max(0.0, delay), std::memory_order_relaxed); }
  /// @}

 private:
  void change(double passed);
  bool listen(double t);
  void place_tool(bool held);
  void feel();
  /// Energy stored by a rotation against a torque that the device does not render. Unit: [J], of the world.
  double unfelt_work(const Wrench& felt);
  double keep_passive(const ForceOutput& felt, bool begins);
  void tell();

  HapticDevice& device_;
  FeltModel used_;
  WorkspaceMap map_;
  double gain_;
  PassiveGain passive_gain_;
  SafetyGovernor governor_;
  PassivityController passivity_;
  bool keeps_passive_;
  double held_for_, counted_hold_;  ///< hold time of a force: filtered, and as the bound has it. Unit: [s].
  double gain_max_ =
      std::numeric_limits<double>::infinity();        ///< largest gain with which the spring is passive
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();  ///< of the model, in the last tick
  Eigen::Quaterniond turned_ = Eigen::Quaterniond::Identity();  ///< orientation of the tool at that tick
  DeviceReading said_;
  bool heard_ = false;  ///< a reading was received
  bool clutched_ = false;
  bool tool_held_ = false;  ///< by the clutch
  bool asked_ = false;      ///< the model was evaluated since its reset
  double asked_at_ = 0.0;   ///< DeviceReading::t of the last evaluation. Unit: [s].
  ContactSet found_;
  Wrench wanted_;
  TickRecord record_;

  struct Next {
    FeltModel model;
    std::uint64_t number = 0;  ///< number of the call of use()
  };
  TripleBuffer<Next> next_;
  std::uint64_t given_ = 0;  ///< number of the last of them
  std::atomic<std::uint64_t> taken_ = 0;
  bool changing_ = false;  ///< next_.front() is pending until the force is zero
  std::atomic<bool> clutch_pressed_ = false;
  struct Place {
    Pose pose;           ///< X_WT
    double reach = 0.0;  ///< Unit: [m].
  };
  TripleBuffer<Place> places_;
  bool brings_ = false;  ///< places_.front() is pending until the force is zero
  std::atomic<double> wanted_gain_, delay_ = 0.0;
};

}  // namespace palpate
