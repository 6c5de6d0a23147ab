/// \file
/// Scene with the contact trackers and force models for one tool.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include <palpate/haptics/zero_order_hold.h>
#include <palpate/live/factories.h>
#include <palpate/live/live_config.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/servo/worker.h>

namespace palpate {

/// Wraps a force model with one that adds further forces; the given model outlives the result. Empty: no
/// wrapper.
using MakeAround = std::function<std::unique_ptr<ForceModel>(ForceModel& model)>;

/// The parts of a live system that are rebuilt when the scene, the tool or the force settings change. Must
/// not be destroyed while a ServoTick uses it.
class FeltScene {
 public:
  /// \param contacts any but kAuto \param clock of the servo loop \param worker_delay Unit: [s]. \param path
  /// SceneConfig::path of the scene \param around wrapper for each model
  FeltScene(std::shared_ptr<const SceneIndex> index, const Tool& tool, const ForceConfig& force,
            const Materials& materials, ContactSearch contacts, const LoopClock& clock, double worker_delay,
            std::string path = {}, const MakeAround& around = {});

  /// \pre one thread at a time
  FeltModel model(ForceModelKind kind);
  const std::shared_ptr<const SceneIndex>& index() const { return index_; }
  const Tool& tool() const { return tool_; }
  const std::string& path() const { return path_; }

 private:
  /// A model and its auxiliary objects.
  struct Model {
    std::unique_ptr<ForceModel> felt;
    std::unique_ptr<ToolTracker> asked;  ///< for `felt`, if that is held
    std::unique_ptr<ZeroOrderHold> held;
    std::unique_ptr<ForceModel> around;  ///< wraps `felt` or `held`
  };

  std::shared_ptr<const SceneIndex> index_;
  std::string path_;
  Tool tool_;
  Lookahead lookahead_;
  Lookahead* ahead_;      ///< &lookahead_, or null if each tracker queries by itself
  ToolTracker contacts_;  ///< used by the servo thread, for the active model
  std::array<Model, kForceModelNames.size()> models_;  ///< by ForceModelKind
  std::unique_ptr<WorkerThread> worker_;               ///< of all models; destroyed before them
};

}  // namespace palpate
