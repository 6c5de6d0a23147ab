#include <palpate/collision/scene_index.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <palpate/base/quantile.h>
#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/contact_output.h>
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
    : storage_(std::move(storage)),
      view_(storage_->view()),
      world_from_scene_(world_from_scene),
      frame_(world_from_scene, view_.origin) {}

void SceneIndex::query(const Ellipsoid& tool, ContactSet& result) const {
  query(tool, Precision::kDouble, result);
}

void SceneIndex::query(const Ellipsoid& tool, Precision precision, ContactSet& result,
                       QueryLimit limit) const {
  find_contacts(view_, ToolFrame(tool, frame_), precision, limit, result);
}

double SceneIndex::usual_extent() const {
  constexpr std::size_t kBlocks = 1024;
  const std::size_t stride = std::max<std::size_t>(1, view_.blocks.size() / kBlocks);
  std::vector<double> extents;
  for (std::size_t i = 0; i < view_.blocks.size(); i += stride) {
    const GaussianBlock& block = view_.blocks[i];
    for (std::size_t lane = 0; lane < kIndexWidth; ++lane) {
      if (!std::isnan(block.position[0][lane]))
        extents.push_back(static_cast<double>(extent_of(block, lane)));
    }
  }
  return extents.empty() ? 0.0 : frame_.scale * quantile(extents, 0.5);
}

std::size_t SceneIndex::bytes() const { return view_.nodes.size_bytes() + view_.blocks.size_bytes(); }

}  // namespace palpate
