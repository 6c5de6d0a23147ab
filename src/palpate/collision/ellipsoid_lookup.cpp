#include <palpate/collision/ellipsoid_lookup.h>

#include <algorithm>
#include <cmath>

#include <tbb/parallel_sort.h>

namespace palpate {

namespace {

std::size_t block_of(std::uint32_t slot) { return slot / kIndexWidth; }
std::size_t lane_of(std::uint32_t slot) { return slot % kIndexWidth; }

Ellipsoid ellipsoid_in(const SceneIndex& index, std::uint32_t slot) {
  const GaussianBlock& block = index.view().blocks[block_of(slot)];
  const std::size_t lane = lane_of(slot);
  Eigen::Vector3d position, lengths;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    position[i] = block.position[k][lane];
    lengths[i] = static_cast<double>(block.length_high[k][lane]) + block.length_low[k][lane];
  }
  const Eigen::Quaterniond rotation(block.rotation[0][lane], block.rotation[1][lane], block.rotation[2][lane],
                                    block.rotation[3][lane]);
  const CapturedFrame& frame = index.frame();
  return {frame.origin + frame.world_from_captured * position,
          frame.world_from_captured * rotation.normalized().toRotationMatrix() * lengths.asDiagonal()};
}

}  // namespace

EllipsoidLookup::EllipsoidLookup(const SceneIndex& index) : index_(index) {
  places_.reserve(index.size());
  std::uint32_t slot = 0;
  for (const GaussianBlock& block : index.view().blocks) {
    for (std::size_t lane = 0; lane < kIndexWidth; ++lane, ++slot) {
      if (!std::isnan(block.position[0][lane])) places_.push_back({block.id[lane], slot});
    }
  }
  tbb::parallel_sort(places_, [](const Place& a, const Place& b) { return a.id < b.id; });
}

Ellipsoid EllipsoidLookup::at(std::uint32_t id) const {
  const auto place = std::lower_bound(places_.begin(), places_.end(), id,
                                      [](const Place& p, std::uint32_t wanted) { return p.id < wanted; });
  return ellipsoid_in(index_, place->slot);
}

EllipsoidScene EllipsoidLookup::all() const {
  EllipsoidScene scene;
  for (const auto& [id, slot] : places_) {
    const GaussianBlock& block = index_.view().blocks[block_of(slot)];
    scene.ellipsoids.push_back(ellipsoid_in(index_, slot));
    scene.opacity.push_back(static_cast<double>(block.opacity_high[lane_of(slot)]) +
                            block.opacity_low[lane_of(slot)]);
    scene.id.push_back(id);
  }
  return scene;
}

}  // namespace palpate
