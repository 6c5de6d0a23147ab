/// \file
/// A live system: a scene, a device, and the servo loop between them.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/base/triple_buffer.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/live/felt_scene.h>
#include <palpate/live/live_config.h>
#include <palpate/live/live_scene.h>
#include <palpate/live/mutual_touch.h>
#include <palpate/live/provenance.h>
#include <palpate/record/trajectory.h>
#include <palpate/servo/admittance_loop.h>
#include <palpate/servo/guarded_device.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// A loaded scene that several systems can share. Immutable.
struct SharedScene {
  SceneConfig config;
  SceneOrigin origin;
  std::shared_ptr<const SceneIndex> index;
  Materials materials;
  std::string materials_file;  ///< ForceConfig::materials that `materials` were read from
};

/// A complete haptic rendering system to embed in an application: loads or generates the scene, opens the
/// device, and runs the servo loop between them. Scene, tool and force model can be changed while it runs.
///
///     LiveSystem system(config);             // opens all of it; throws Error
///     system.start({&view});                 // motors on
///     system.change([](LiveConfig& c) { c.force.proxy.stiffness = 800.0; });
///     system.stop();                         // the force falls, motors off
///
/// Threads: construction, start(), stop() and destruction belong to the owner's thread. Functions marked "any
/// thread" may be called by any thread between start() and stop().
class LiveSystem {
 public:
  /// Loads the scene, or generates the built-in one if the path is empty, and opens the device; waits for its
  /// calibration if one is needed. Owner's thread. \param device the caller's device; null: creates one of
  /// DeviceConfig::kind. Only DeviceConfig::map applies to the caller's device. \param notify receives
  /// notices for the user, on the owner's thread or, when the scene changes later, on a separate thread; may
  /// be empty \throws Error as check_config(), for a scene, trajectory, tool or material that cannot be read,
  /// or a device that cannot be opened.
  explicit LiveSystem(const LiveConfig& config, std::unique_ptr<HapticDevice> device = nullptr,
                      const Notify& notify = {}, const Progress& progress = {});
  /// The same on a scene that another system has loaded, without a second copy in memory. The other system
  /// owns the scene; see follow(). `config.scene` is ignored.
  LiveSystem(const LiveConfig& config, const SharedScene& scene, std::unique_ptr<HapticDevice> device,
             const Notify& notify);
  /// As stop().
  ~LiveSystem();
  LiveSystem(const LiveSystem&) = delete;
  LiveSystem& operator=(const LiveSystem&) = delete;

  /// Enables the motors, which have no force before start(). A program of several systems enables all before
  /// it starts one: a driver may take long, or hang. Owner's thread; further calls do nothing. \throws Error
  /// if the device cannot be enabled, and if the system has been stopped.
  void enable();
  /// Enables the motors, unless enable() has, and starts the loop. Owner's thread, once. \param observers
  /// receive every tick, on the servo thread; must outlive stop() \throws Error as enable(), and if the
  /// system has been started before.
  void start(std::vector<TickObserver*> observers);
  /// Ramps the force down, brings a device of the admittance type to rest within MotionLimits::stop_time(),
  /// stops the loop and closes the device. After stop_force(Fault::kEnded) it waits less: when several
  /// systems stop, their forces fall together. Owner's thread; further calls do nothing. A device whose
  /// driver does not return, from the loop or within 5 s from close(), is stopped and not closed; it and its
  /// thread are then left behind.
  void stop();
  /// Returns whether stop() had to leave the device behind. Owner's thread.
  bool has_left_device() const { return device_hangs_; }

  /// Called with every newly active scene, on a separate thread. Must be set before start(). What it throws
  /// becomes message(); the scene stays active.
  std::function<void(const SharedScene& scene)> on_scene;
  /// Enables mutual touch with the other hands of `touch` from start() on. Must be called before start().
  /// \param hand its index in `touch`. \pre `touch` outlives it
  void touch_others(MutualTouch& touch, std::size_t hand) {
    touch_ = &touch;
    number_ = hand;
  }
  /// Returns the scene, for constructing another system on it. Any thread.
  SharedScene scene() const;

  /// \name Any thread, after start()
  /// @{
  /// Returns the requested settings, which may not have taken effect yet.
  LiveConfig settings() const;
  /// Applies `edit` to scene (except its file), tool, force (except materials) and room; other edits are
  /// reverted. Returns immediately: the new scene and models are built on another thread and take effect once
  /// they are ready and the force has ramped to zero. The stiffness takes effect at once. If building fails,
  /// the other settings revert and message() says why. Exceptions of `edit` propagate and nothing is changed.
  /// \param edit called twice, with other threads locked out: for the requested settings, and for those that
  /// return if the change in progress fails. It must therefore not move from what it captures, nor change
  /// this system otherwise than by its argument \throws Error as check_config() for what it results in, if
  /// `edit` changes a scene that another system owns, or this system, and before start().
  void change(const std::function<void(LiveConfig&)>& edit);
  /// Opens another scene in place of the active one; asynchronous as change(). Placement, crop and the
  /// materials file are reset, since they belong to the old scene. \param path empty: the built-in scene
  /// \throws Error if needs_its_scene() is not empty, if another system owns the scene, and before start().
  void open_scene(const std::string& path);
  /// Returns why no other scene can be opened: a giant's scene is placed where its handle rests, and a
  /// playback belongs to its scene; empty if one can be opened.
  std::string_view needs_its_scene() const;
  /// Returns whether a change of the scene's scale or placement would change what something else means: the
  /// settings have world coordinates or lengths (a trajectory, the workspace map, materials, a crop, a limit
  /// of size), the scene was placed at start-up, or a client holds the tool. Nobody but a user who asks for
  /// it should then change them.
  bool uses_world() const;
  /// Switches to the scene of another system, for a system constructed on a shared scene; asynchronous as
  /// change(). The latest call wins.
  void follow(const SharedScene& scene);
  /// Returns the provenance of the current scene, settings and recording. Reads the materials file, if any.
  /// \throws Error if that cannot be read.
  Provenance provenance(std::string_view command) const;
  /// Returns a description of the work in progress; empty if there is none.
  std::string busy() const;
  /// Returns why the last change failed; empty if it succeeded or is still in progress.
  std::string message() const;
  /// Returns a version number that changes with settings(), busy(), message() and felt().
  std::uint64_t version() const;
  /// Returns the active scene, kept alive by the returned pointer.
  std::shared_ptr<const FeltScene> felt() const;

  /// Stops the force; before start(), that of the loop to come, until resume(). A device of the admittance
  /// type is also brought to rest if ending the fault takes resume(), except in a pause, in which its handle
  /// can be moved. May also be called from signal handlers, and before start().
  void stop_force(Fault why = Fault::kEmergencyStop);
  /// Turns the motors off at once, for a program that is about to terminate. May also be called from signal
  /// handlers, and before start().
  void stop_motors() noexcept;
  /// Clears the stops of stop_force(), pauses, and all other latched faults.
  void resume();
  /// Returns the loop's tick, whose governor stops and resumes the force; see ServoTick for its thread rules.
  ServoTick& tick() { return *tick_; }
  ServoLoop& loop() { return *loop_; }
  /// Returns the loop's clock, on which all tick times are.
  const LoopClock& clock() const { return clock_; }
  const DeviceCapabilities& device() const { return device_->capabilities(); }
  /// Returns a name of kDeviceKindNames; "external" for the caller's device and for drivers.
  std::string_view device_kind() const { return device_kind_; }
  /// Returns the fault text of the device; empty without a fault.
  std::string_view device_fault() const {
    if (!guarded_->thrown().empty()) return guarded_->thrown();
    return device_->status() == DeviceStatus::kFault ? device_->status_text() : std::string_view();
  }
  /// Returns what limits the motion of a device of the admittance type; empty if nothing does.
  std::string_view device_held_by() const {
    return device_->status() == DeviceStatus::kEnabled ? device_->status_text() : std::string_view();
  }
  /// Returns the pose input of a gateway client, which leads the simulated hand or is the device.
  ClientHand& client_hand() { return client_hand_; }
  /// Returns whether the simulated hand moves by itself. A client that leads the hand ends this: afterwards
  /// the hand stays where it was left, until set_moves_itself(true).
  bool moves_itself() const { return moves_itself_.load(std::memory_order_relaxed); }
  void set_moves_itself(bool on) { moves_itself_.store(on, std::memory_order_relaxed); }
  /// Returns whether there is a simulated hand.
  bool has_hand() const {
    return owns_device_ && (home_ || device_kind_ == to_string(DeviceKind::kSimulated));
  }
  /// Returns the contact search in use; never kAuto.
  ContactSearch contacts() const { return contacts_; }
  /// Length of the recorded motion that is played back; 0 if there is none. Unit: [s].
  double playback_length() const { return length_; }
  /// @}

 private:
  LiveSystem(const LiveConfig& config, const SharedScene* scene, std::unique_ptr<HapticDevice> device,
             const Notify& notify, const Progress& progress);
  void read_motion();
  void read_scene(const Progress& progress);
  void take(const SharedScene& scene);
  void place_giant();
  void find_way();
  Trajectory explore(const SceneIndex& index, const LiveConfig& config) const;
  Trajectory explore_room(const SceneIndex& index, const LiveConfig& config) const;
  void open(std::unique_ptr<HapticDevice> device);
  void go(const Trajectory& path);
  std::shared_ptr<FeltScene> make_felt(std::shared_ptr<const SceneIndex> index, const LiveConfig& settings,
                                       const Materials& materials) const;
  void change_until_stopped(LiveConfig done);
  SharedScene read_again(const LiveConfig& wanted, const LiveConfig& now);
  SharedScene taken_over(const LiveConfig& wanted, const SharedScene& followed) const;
  void apply(const LiveConfig& wanted, const LiveConfig& now, const SharedScene& scene);
  void lead_hand(const SceneIndex& index, const LiveConfig& wanted);
  void let_hand_move();
  void set_gain();
  void revert(LiveConfig& done);
  void change_admittance(double stiffness);
  void announce(const SharedScene& scene);
  void say(const std::string& busy);
  Progress progress_of(const std::string& name);
  LiveConfig edited(const LiveConfig& settings, const std::function<void(LiveConfig&)>& edit,
                    const std::string* path) const;
  void become(const std::function<void(LiveConfig&)>& edit, const std::string* path);

  Notify notify_;
  LoopClock clock_;
  ContactSearch contacts_;
  double stiffness_;  ///< stiffness at gain 1. Unit: [N/m]. > 0
  bool explores_ = false;
  Trajectory path_;  ///< in the world frame; of a playback, in the device frame
  /// Path of the simulated hand, world frame; written by one thread at a time.
  TripleBuffer<std::shared_ptr<const HandPath>> way_;
  ClientHand client_hand_;
  std::atomic<bool> moves_itself_ = true;
  double length_ = 0.0;
  std::optional<GiantSetup> giant_;  ///< with the chain as it was read at the start
  std::optional<Pose> home_;         ///< rest pose of a giant's handle, device's frame
  bool owns_device_;                 ///< the device is not the caller's
  std::string_view device_kind_;
  bool follows_;  ///< follows another system, which owns the scene
  MutualTouch* touch_ = nullptr;
  std::size_t number_ = 0;  ///< index of this hand in *touch_
  std::unique_ptr<HapticDevice> device_;
  std::optional<GuardedDevice> guarded_;  ///< device_ as the loop sees it
  AdmittanceLoop* admittance_ = nullptr;  ///< the device, if it is of that type
  bool device_hangs_ = false;
  bool enabled_ = false;
  std::unique_ptr<ServoTick> tick_;
  std::atomic<ServoTick*> running_ = nullptr;        ///< tick_, for signal handlers
  std::atomic<Fault> asked_to_stop_ = Fault::kNone;  ///< by stop_force(), the last one
  std::atomic<bool> is_over_ = false;                ///< no resume() brings the force back
  std::unique_ptr<ServoLoop> loop_;

  mutable std::recursive_mutex mutex_;  ///< guards the members below; an edit may ask for them
  std::condition_variable_any wanted_;
  LiveConfig settings_;   ///< device, loop and gateway never change
  LiveConfig active_;     ///< settings in effect
  LiveConfig fallback_;   ///< what settings_ return to if the change in progress fails
  SharedScene scene_;     ///< active scene; changed by the changer thread only
  SharedScene followed_;  ///< scene to switch to, if it follows another system
  std::string busy_, message_;
  std::uint64_t version_ = 0, settings_version_ = 0;
  bool ends_ = false;
  std::shared_ptr<FeltScene> felt_;  ///< changed by the changer thread only
  std::shared_ptr<FeltScene> next_;  ///< used by the changer thread only
  std::thread changer_;
};

}  // namespace palpate
