/// \file
/// A scene, as all force models feel it with one tool.
#pragma once

#include <array>
#include <memory>
#include <string>

#include <palpate/haptics/held_force.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/servo/worker.h>

#include "options.h"

namespace palpate::cli {

/// Everything of a live system that is made anew when a person changes the scene, the tool, or what is felt
/// of them. Nothing of it may go while a ServoTick uses it.
class FeltScene {
 public:
  /// \param contacts "inline", "worker" or "hold". \param clock the loop's. \param worker_delay Unit: [s].
  FeltScene(std::shared_ptr<const SceneIndex> index, const Tool& tool, const ForceOptions& force,
            const ForceOptions::Materials& made_of, const std::string& contacts, const LoopClock& clock,
            double worker_delay);

  /// Of kModels[k].
  FeltModel model(std::size_t k);
  const std::shared_ptr<const SceneIndex>& index() const { return index_; }
  const Tool& tool() const { return tool_; }

 private:
  /// Everything that one of kModels needs.
  struct Model {
    std::unique_ptr<ForceModel> felt;
    std::unique_ptr<ToolTracker> asked;  ///< for `felt` where that is held
    std::unique_ptr<HeldForce> held;
  };

  std::shared_ptr<const SceneIndex> index_;
  Tool tool_;
  Lookahead lookahead_;
  Lookahead* ahead_;      ///< that, or null where each looks for itself
  ToolTracker contacts_;  ///< of the servo thread, for whichever model it feels
  std::array<Model, kModels.size()> models_;
  std::unique_ptr<WorkerThread> worker_;  ///< of all models; gone before them
};

}  // namespace palpate::cli
