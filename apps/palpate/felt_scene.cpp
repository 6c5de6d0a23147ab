#include "felt_scene.h"

namespace palpate::cli {

FeltScene::FeltScene(std::shared_ptr<const SceneIndex> index, const Tool& tool, const ForceOptions& force,
                     const ForceOptions::Materials& made_of, const std::string& contacts,
                     const LoopClock& clock, double worker_delay)
    : index_(std::move(index)),
      tool_(tool),
      ahead_(contacts == "worker" ? &lookahead_ : nullptr),
      contacts_(*index_, tool_, Precision::kDouble, ahead_) {
  std::vector<BackgroundWork*> work;
  if (ahead_ != nullptr) work.push_back(ahead_);
  for (std::size_t k = 0; k < kModels.size(); ++k) {
    Model& model = models_[k];
    model.felt = force.build(kModels[k], *index_, tool_, made_of, ahead_);
    if (contacts != "hold") continue;
    if (model.felt->wants_contacts()) model.asked = std::make_unique<ToolTracker>(*index_, tool_);
    model.held = std::make_unique<HeldForce>(*model.felt, model.asked.get());
    work.push_back(model.held.get());
  }
  if (!work.empty()) worker_ = std::make_unique<WorkerThread>(work, clock, worker_delay);
}

FeltModel FeltScene::model(std::size_t k) {
  Model& model = models_[k];
  ForceModel* const felt = model.held ? static_cast<ForceModel*>(model.held.get()) : model.felt.get();
  return {felt, &contacts_, worker_.get()};
}

}  // namespace palpate::cli
