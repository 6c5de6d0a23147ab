#include <palpate/live/felt_scene.h>

#include <utility>
#include <vector>

namespace palpate {

FeltScene::FeltScene(std::shared_ptr<const SceneIndex> index, const Tool& tool, const ForceConfig& force,
                     const Materials& materials, ContactSearch contacts, const LoopClock& clock,
                     double worker_delay, std::string path, const MakeAround& around)
    : index_(std::move(index)),
      path_(std::move(path)),
      tool_(tool),
      ahead_(contacts == ContactSearch::kWorker ? &lookahead_ : nullptr),
      contacts_(*index_, tool_, Precision::kDouble, ahead_) {
  std::vector<BackgroundWork*> work;
  if (ahead_ != nullptr) work.push_back(ahead_);
  for (std::size_t k = 0; k < models_.size(); ++k) {
    Model& model = models_[k];
    model.felt = make_force_model(static_cast<ForceModelKind>(k), force, *index_, tool_, materials, ahead_);
    ForceModel* felt = model.felt.get();
    if (contacts == ContactSearch::kHold) {
      if (felt->wants_contacts()) model.asked = std::make_unique<ToolTracker>(*index_, tool_);
      model.held = std::make_unique<ZeroOrderHold>(*felt, model.asked.get());
      work.push_back(model.held.get());
      felt = model.held.get();
    }
    if (around) model.around = around(*felt);
  }
  if (!work.empty()) worker_ = std::make_unique<WorkerThread>(work, clock, worker_delay);
}

FeltModel FeltScene::model(ForceModelKind kind) {
  Model& model = models_[static_cast<std::size_t>(kind)];
  ForceModel* const felt = model.held ? static_cast<ForceModel*>(model.held.get()) : model.felt.get();
  return {model.around ? model.around.get() : felt, &contacts_, worker_.get()};
}

}  // namespace palpate
