/// \file
/// A scene with the trackers and force models that feel it with one tool.
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

/// Makes a model that feels more than the one it is given, which outlives it; empty: there is no more.
using MakeAround = std::function<std::unique_ptr<ForceModel>(ForceModel& model)>;

/// Everything of a live system that is made anew when a person changes the scene, the tool, or what is felt
/// of them. Nothing of it may go while a ServoTick uses it.
class FeltScene {
 public:
  /// \param contacts but kAuto \param clock the loop's \param worker_delay Unit: [s]. \param path
  /// SceneConfig::path of the scene \param around what each model is felt with besides
  FeltScene(std::shared_ptr<const SceneIndex> index, const Tool& tool, const ForceConfig& force,
            const Materials& materials, ContactSearch contacts, const LoopClock& clock, double worker_delay,
            std::string path = {}, const MakeAround& around = {});

  /// \pre one thread at a time
  FeltModel model(ForceModelKind kind);
  const std::shared_ptr<const SceneIndex>& index() const { return index_; }
  const Tool& tool() const { return tool_; }
  const std::string& path() const { return path_; }

 private:
  /// Everything that a model needs.
  struct Model {
    std::unique_ptr<ForceModel> felt;
    std::unique_ptr<ToolTracker> asked;  ///< for `felt` where that is held
    std::unique_ptr<ZeroOrderHold> held;
    std::unique_ptr<ForceModel> around;  ///< either of them
  };

  std::shared_ptr<const SceneIndex> index_;
  std::string path_;
  Tool tool_;
  Lookahead lookahead_;
  Lookahead* ahead_;                                   ///< that, or null where each looks for itself
  ToolTracker contacts_;                               ///< of the servo thread, for whichever model it feels
  std::array<Model, kForceModelNames.size()> models_;  ///< by ForceModelKind
  std::unique_ptr<WorkerThread> worker_;               ///< of all models; gone before them
};

}  // namespace palpate
