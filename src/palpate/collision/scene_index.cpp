#include <palpate/collision/scene_index.h>

#include <utility>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/index_storage.h>
#include <palpate/collision/record_collector.h>

namespace palpate {
namespace {

std::shared_ptr<const IndexStorage> build(const GaussianScene& scene, const SceneFilter& filter,
                                          const Similarity& world_from_scene, const Progress& progress) {
  RecordCollector collector(filter, world_from_scene);
  collector.add(scene);
  return build_arrays(collector.records(), scene.origin, progress);
}

}  // namespace

SceneIndex::SceneIndex(const GaussianScene& scene, const SceneFilter& filter,
                       const Similarity& world_from_scene, const Progress& progress)
    : SceneIndex(build(scene, filter, world_from_scene, progress), world_from_scene) {}

SceneIndex::SceneIndex(std::shared_ptr<const IndexStorage> storage, const Similarity& world_from_scene)
    : storage_(std::move(storage)), view_(storage_->view()), frame_(world_from_scene, view_.origin) {}

void SceneIndex::query(const Ellipsoid& tool, ContactSet& result) const {
  query(tool, Precision::kDouble, result);
}

void SceneIndex::query(const Ellipsoid& tool, Precision precision, ContactSet& result) const {
  find_contacts(view_, ToolFrame(tool, frame_), precision, result);
}

std::size_t SceneIndex::bytes() const { return view_.nodes.size_bytes() + view_.blocks.size_bytes(); }

}  // namespace palpate
