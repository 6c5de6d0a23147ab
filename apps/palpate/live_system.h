/// \file
/// A scene, a device and the loop between them, put together.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <palpate/device/playback_device.h>
#include <palpate/device/simulated_device.h>
#include <palpate/haptics/held_force.h>
#include <palpate/servo/live_view.h>
#include <palpate/servo/servo_loop.h>
#include <palpate/servo/worker.h>

#include "options.h"

namespace palpate::cli {

/// Which device, where it is, and who holds it.
struct DeviceOptions {
  std::string device = "simulated";
  std::string profile = "omega";
  std::string trajectory;  ///< of the hand, or of the tool; empty: a touch_path() of the scene
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

/// What a loop runs on, and what it is asked for. All of it lives as long as this.
class LiveSystem {
 public:
  /// Reads the scene, or makes the built-in one if it has no path. \throws Error.
  LiveSystem(const SceneOptions& scene, const QueryOptions& query, const ForceOptions& force,
             const DeviceOptions& device, const LoopOptions& loop, const Progress& progress);

  /// Begins, with the worker if one is needed. `observers` must outlive this.
  void start(std::vector<TickObserver*> observers);
  /// Ramps the force down and ends.
  void stop();

  /// From here on, kModels[k].
  void use_model(std::size_t k);
  std::size_t model() const { return model_; }
  ServoTick& tick() { return *tick_; }
  ServoLoop& loop() { return *loop_; }
  const LoopClock& clock() const { return clock_; }
  const DeviceCapabilities& device() const { return device_->capabilities(); }
  double stiffness() const { return stiffness_; }  ///< of gain 1. Unit: [N/m].
  /// "inline", "worker" or "hold".
  const std::string& contacts() const { return contacts_; }
  /// Of the recorded motion that is played back; 0 if there is none. Unit: [s].
  double playback_length() const { return length_; }
  std::string scene_text() const { return scene_text_; }

 private:
  /// Everything that one of kModels needs.
  struct Model {
    std::unique_ptr<ForceModel> felt;
    std::unique_ptr<ToolTracker> contacts;  ///< for `felt`, or for who looks on
    std::unique_ptr<ToolTracker> asked;     ///< for `felt` where that is held
    std::unique_ptr<HeldForce> held;
  };

  void read_scene(const SceneOptions& scene, const QueryOptions& query, const DeviceOptions& device,
                  const Progress& progress);
  void make_models(const SceneOptions& scene, const QueryOptions& query, const ForceOptions& force,
                   const Progress& progress);
  void make_device(const DeviceOptions& options);
  FeltModel felt(std::size_t k);

  LoopOptions options_;
  LoopClock clock_;
  std::unique_ptr<SceneIndex> index_;
  std::string scene_text_, contacts_;
  Trajectory path_;  ///< in the world; once it is played back, of the device
  WorkspaceMap map_;
  Lookahead lookahead_;
  std::array<Model, kModels.size()> models_;
  std::size_t model_ = 0;
  double stiffness_, length_ = 0.0;
  std::unique_ptr<HapticDevice> device_;
  std::unique_ptr<WorkerThread> worker_;
  std::unique_ptr<ServoTick> tick_;
  std::unique_ptr<ServoLoop> loop_;
};

}  // namespace palpate::cli
