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

/// A scene that has been read, for others that feel it as well. Immutable.
struct SharedScene {
  SceneConfig config;
  SceneOrigin origin;
  std::shared_ptr<const SceneIndex> index;
  Materials materials;
  std::string materials_file;  ///< ForceConfig::materials that `materials` are of
};

/// What an application embeds: reads or makes the scene, opens the device, and runs the servo loop between
/// them, while scene, tool and model may be changed.
///
///     LiveSystem system(config);             // opens all of it; throws Error
///     system.start({&view});                 // motors on
///     system.change([](LiveConfig& c) { c.force.proxy.stiffness = 800.0; });
///     system.stop();                         // the force falls, motors off
///
/// Threads: construction, start(), stop() and destruction belong to the owner's thread. What says "any
/// thread" may be called by any other between start() and stop().
class LiveSystem {
 public:
  /// Reads the scene, or makes the built-in one if it has no path, and opens the device, for whose
  /// calibration it waits where that is needed. Owner's thread. \param device the caller's own; null: one of
  /// DeviceConfig::kind. Of DeviceConfig, one's own has `map` alone. \param notify told what a person should
  /// know, on the owner's thread; may be empty \throws Error for a scene, trajectory, tool or material that
  /// cannot be read, or a device that cannot be opened.
  explicit LiveSystem(const LiveConfig& config, std::unique_ptr<HapticDevice> device = nullptr,
                      const Notify& notify = {}, const Progress& progress = {});
  /// The same over a scene that another has read: no memory is taken for it once more. It stays that of the
  /// other: see follow(). Of `config`, `scene` does not count.
  LiveSystem(const LiveConfig& config, const SharedScene& scene, std::unique_ptr<HapticDevice> device,
             const Notify& notify);
  /// As stop().
  ~LiveSystem();
  LiveSystem(const LiveSystem&) = delete;
  LiveSystem& operator=(const LiveSystem&) = delete;

  /// Motors on, and begins. Owner's thread, once. \param observers see every tick, on the servo thread; must
  /// outlive stop() \throws Error if the device cannot be enabled.
  void start(std::vector<TickObserver*> observers);
  /// The force begins to fall. Owner's thread, before stop(), which then waits for less: where several end,
  /// they fall together.
  void begin_to_stop();
  /// Ramps the force down, closes the device and ends. Owner's thread; more than once does nothing.
  void stop();

  /// Told of every other scene once it is felt, on a thread of its own. To be set before start().
  std::function<void(const SharedScene& scene)> on_scene;
  /// From start() on it feels the others of `touch`, and they feel it. To be called before. \param hand its
  /// number there. \pre `touch` outlives it
  void touch_others(MutualTouch& touch, std::size_t hand) {
    touch_ = &touch;
    number_ = hand;
  }
  /// What another may be made over. Any thread.
  SharedScene scene() const;

  /// \name From any thread, once it has started
  /// @{
  /// What is wanted. What that takes may still be in the making.
  LiveConfig settings() const;
  /// Has `edit` change scene (but for its file), tool, force (but for materials) and room; other edits are
  /// undone. What it comes to is made on another thread, and felt once it is there and the force has fallen;
  /// returns at once. If it cannot be made, the settings become what they were, and message() says why. What
  /// `edit` throws is thrown, and nothing changed. \throws Error if the scene is another's, and `edit`
  /// changes it.
  void change(const std::function<void(LiveConfig&)>& edit);
  /// Opens another scene in place of the one that is felt: as change(), with where it is, its crop and the
  /// materials of a file forgotten, since they are of the old one. \param path empty: the built-in one
  /// \throws Error where needs_its_scene(), and where the scene is another's.
  void open_scene(const std::string& path);
  /// Why no other scene can be opened, with a giant, whose scene is where its handle rests, and where poses
  /// are played back; empty where one can.
  std::string_view needs_its_scene() const;
  /// Has the scene of another be felt, of a system that was made over it: as change(). The newest counts.
  void follow(const SharedScene& scene);
  /// How what is felt and recorded now is made. Reads the file of the materials, where there is one. \throws
  /// Error if that cannot be read.
  Provenance provenance(std::string_view command) const;
  /// What is being made; empty if nothing is.
  std::string busy() const;
  /// Why the last change failed; empty if it did not, or is still in the making.
  std::string message() const;
  /// Another number whenever one of these four changes.
  std::uint64_t version() const;
  /// The scene that is felt, which is kept as long as it is held.
  std::shared_ptr<const FeltScene> felt() const;

  /// No force, and a device of the admittance type is at rest where that takes resume() to end. Signal
  /// handlers too.
  void stop_force(Fault why = Fault::kEmergencyStop);
  /// Ends all that stop_force() began but for pauses, and faults that latch.
  void resume();
  /// The loop's tick: its governor stops and resumes the force. What may be called when, it says itself.
  ServoTick& tick() { return *tick_; }
  ServoLoop& loop() { return *loop_; }
  /// The loop's, on which all times of ticks are.
  const LoopClock& clock() const { return clock_; }
  const DeviceCapabilities& device() const { return device_->capabilities(); }
  /// A name of kDeviceKindNames; "external" for the caller's own and for drivers.
  std::string_view device_kind() const { return device_kind_; }
  /// What the device says of itself in a fault; else empty.
  std::string_view device_fault() const {
    if (!guarded_->thrown().empty()) return guarded_->thrown();
    return device_->status() == DeviceStatus::kFault ? device_->status_text() : std::string_view();
  }
  /// What keeps it from its motion, of the admittance type; empty where nothing does.
  std::string_view device_held_by() const {
    return device_->status() == DeviceStatus::kEnabled ? device_->status_text() : std::string_view();
  }
  /// Where a client's hand is, which leads the simulated one, or is the device.
  ClientHand& client_hand() { return client_hand_; }
  /// Whether the simulated hand moves by itself. A client that leads it ends that: afterwards the hand stays
  /// where it was left, until it is set to move again.
  bool moves_itself() const { return moves_itself_.load(std::memory_order_relaxed); }
  void set_moves_itself(bool on) { moves_itself_.store(on, std::memory_order_relaxed); }
  /// Whether there is a simulated hand.
  bool has_hand() const {
    return owns_device_ && (home_ || device_kind_ == to_string(DeviceKind::kSimulated));
  }
  /// Who looks for contacts; never kAuto.
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
  Trajectory explore(const SceneIndex& index, const Tool& tool) const;
  Trajectory explore_room(const SceneIndex& index, const Tool& tool) const;
  void open(std::unique_ptr<HapticDevice> device);
  void go(const Trajectory& path);
  std::shared_ptr<FeltScene> make_felt(std::shared_ptr<const SceneIndex> index, const LiveConfig& settings,
                                       const Materials& materials) const;
  void change_until_stopped(LiveConfig done);
  SharedScene read_again(const LiveConfig& wanted, const LiveConfig& now);
  SharedScene taken_over(const LiveConfig& wanted, const SharedScene& followed) const;
  void apply(const LiveConfig& wanted, const LiveConfig& now, const SharedScene& scene);
  void lead_hand(const SceneIndex& index, const Tool& tool);
  void let_hand_move();
  void set_stiffness(const LiveConfig& settings);
  void say(const std::string& busy);
  Progress progress_of(const std::string& name);
  void become(const std::function<void(LiveConfig&)>& edit, const std::string* path);

  Notify notify_;
  LoopClock clock_;
  ContactSearch contacts_;
  double stiffness_;  ///< of gain 1. Unit: [N/m].
  bool explores_ = false;
  Trajectory path_;  ///< in the world; once it is played back, of the device
  /// Where the simulated hand goes: in the world; written by one thread at a time.
  TripleBuffer<std::shared_ptr<const HandPath>> way_;
  ClientHand client_hand_;
  std::atomic<bool> moves_itself_ = true;
  double length_ = 0.0;
  std::optional<Pose> home_;  ///< of a giant's handle, device's frame
  bool owns_device_;          ///< it is none of the caller's
  std::string_view device_kind_;
  bool follows_;  ///< another, which has the scene
  MutualTouch* touch_ = nullptr;
  std::size_t number_ = 0;  ///< there
  std::unique_ptr<HapticDevice> device_;
  std::optional<GuardedDevice> guarded_;  ///< the same, as the loop sees it
  AdmittanceLoop* admittance_ = nullptr;  ///< the device, if it is of that type
  std::unique_ptr<ServoTick> tick_;
  std::unique_ptr<ServoLoop> loop_;

  mutable std::mutex mutex_;  ///< of what follows
  std::condition_variable wanted_;
  LiveConfig settings_;   ///< of which device, loop and gateway never change
  SharedScene scene_;     ///< that is felt; changed by the changer's thread only
  SharedScene followed_;  ///< that is to be felt, of one that follows another
  std::string busy_, message_;
  std::uint64_t version_ = 0, settings_version_ = 0;
  bool ends_ = false;
  std::shared_ptr<FeltScene> felt_;  ///< changed by the changer's thread only
  std::shared_ptr<FeltScene> next_;  ///< that thread's
  std::thread changer_;
};

}  // namespace palpate
