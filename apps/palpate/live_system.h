/// \file
/// A scene, a device and the loop between them, put together.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/latest_value.h>
#include <palpate/device/playback_device.h>
#include <palpate/device/simulated_device.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/servo/servo_loop.h>

#include "felt_scene.h"
#include "options.h"

namespace palpate::cli {

/// Which device, where it is, and who holds it.
struct DeviceOptions {
  std::string device = "simulated";
  std::string profile = "omega";
  std::string trajectory;     ///< of the hand, or of the tool; empty: a touch_path() of the scene
  double client_rate = 60.0;  ///< Unit: [Hz].
  HandProperties hand;
  WorkspaceMap map;

  void declare(CLI::App& app);
};

/// How the loop runs.
struct LoopOptions {
  double rate = 1000.0;  ///< Unit: [Hz].
  std::string contacts = "auto";
  double worker_delay = 0.0;  ///< Unit: [s].
  int cpu = -1;               ///< to pin the servo thread to; -1: none

  void declare(CLI::App& app);
};

/// What a person may change while a hand holds on.
struct LiveSettings {
  SceneOptions scene;  ///< but for its path
  Tool tool;
  ForceOptions force;
  std::size_t model = 0;  ///< of kModels
  Similarity room;        ///< from the room that a headset knows to the world
};

/// What a loop runs on, and what it is asked for. All of it lives as long as this.
class LiveSystem {
 public:
  /// Reads the scene, or makes the built-in one if it has no path, and opens the device, for whose
  /// calibration it waits where that is needed. \throws Error.
  LiveSystem(const SceneOptions& scene, const QueryOptions& query, const ForceOptions& force,
             const DeviceOptions& device, const LoopOptions& loop, const Progress& progress);
  ~LiveSystem();

  /// Motors on, and begins. `observers` must outlive this. \throws Error if the device cannot be enabled.
  void start(std::vector<TickObserver*> observers);
  /// Ramps the force down, closes the device and ends.
  void stop();

  /// \name From any thread, once it has started
  /// @{
  /// What is wanted. What that takes may still be in the making.
  LiveSettings settings() const;
  /// Has `edit` change them. What it comes to is made on another thread, and felt once it is there; returns
  /// at once. If it cannot be made, the settings become what they were, and message() says why.
  void change(const std::function<void(LiveSettings&)>& edit);
  /// What is being made; empty if nothing is.
  std::string busy() const;
  std::string message() const;
  /// Another number whenever something of these four changes.
  std::uint64_t version() const;
  /// What is felt.
  std::shared_ptr<const FeltScene> felt() const;
  /// @}

  ServoTick& tick() { return *tick_; }
  ServoLoop& loop() { return *loop_; }
  const LoopClock& clock() const { return clock_; }
  const DeviceCapabilities& device() const { return device_->capabilities(); }
  /// What it says of itself in a fault; else empty.
  std::string_view device_fault() const {
    return device_->status() == DeviceStatus::kFault ? device_->status_text() : std::string_view();
  }
  ClientHand& client_hand() { return client_hand_; }
  /// "inline", "worker" or "hold".
  const std::string& contacts() const { return contacts_; }
  /// Of the recorded motion that is played back; 0 if there is none. Unit: [s].
  double playback_length() const { return length_; }
  std::string scene_text() const { return settings().scene.name(); }

 private:
  void read_scene(const QueryOptions& query, const DeviceOptions& device, const Progress& progress);
  static std::shared_ptr<const SceneIndex> read_index(const SceneOptions& scene, IndexFiles files,
                                                      const Progress& progress);
  Trajectory explore(const SceneIndex& index, const Tool& tool) const;
  void make_device(const DeviceOptions& options);
  void go(const Trajectory& path);
  HandPath simulated_hand();
  std::shared_ptr<FeltScene> make_felt(std::shared_ptr<const SceneIndex> index,
                                       const LiveSettings& settings) const;
  void change_until_stopped(LiveSettings done);
  void apply(const LiveSettings& wanted, const LiveSettings& now);
  void set_gain(const LiveSettings& settings);
  void say(const std::string& busy);

  LoopOptions options_;
  LoopClock clock_;
  std::string contacts_;
  ForceOptions::Materials made_of_;
  double stiffness_;              ///< of gain 1. Unit: [N/m].
  double exploring_speed_ = 0.0;  ///< Unit: [m/s].
  bool explores_ = false;
  std::shared_ptr<const SceneIndex> index_;
  Trajectory path_;  ///< in the world; once it is played back, of the device
  /// Where the simulated hand goes: in the world; written by one thread at a time.
  LatestValue<std::shared_ptr<const HandPath>> way_;
  ClientHand client_hand_;
  WorkspaceMap map_;
  double length_ = 0.0;
  std::unique_ptr<HapticDevice> device_;
  std::unique_ptr<ServoTick> tick_;
  std::unique_ptr<ServoLoop> loop_;

  mutable std::mutex mutex_;  ///< of what follows
  std::condition_variable wanted_;
  LiveSettings settings_;
  std::string busy_, message_;
  std::uint64_t version_ = 0, settings_version_ = 0;
  bool ends_ = false;
  std::shared_ptr<FeltScene> felt_;  ///< changed by the changer's thread only
  std::shared_ptr<FeltScene> next_;  ///< that thread's
  std::thread changer_;
};

}  // namespace palpate::cli
