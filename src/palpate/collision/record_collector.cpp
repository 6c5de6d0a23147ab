#include <palpate/collision/record_collector.h>

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <palpate/collision/two_floats.h>

namespace palpate {
namespace {

/// Gaussians per task: about 0.3 ms.
constexpr std::size_t kBlock = 2048;

GaussianRecord record_of(const GaussianScene& scene, std::size_t i, const Gaussian& activated,
                         const SceneFilter& filter) {
  const Eigen::Vector3f& p = scene.position[i];
  const Eigen::Vector4f& q = scene.rotation[i];
  GaussianRecord r{{p[0], p[1], p[2]}, {}, {}, {q[0], q[1], q[2], q[3]}, 0, 0, scene.id[i]};
  const double k = sigma_multiple(activated.opacity, filter);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    split(k * activated.sigma[static_cast<int>(axis)], r.length_high[axis], r.length_low[axis]);
  }
  split(activated.opacity, r.opacity_high, r.opacity_low);
  return r;
}

Eigen::AlignedBox3f box_of(const GaussianRecord& r) {
  const Eigen::Quaterniond q(r.rotation[0], r.rotation[1], r.rotation[2], r.rotation[3]);
  const Eigen::Vector3d length(static_cast<double>(r.length_high[0]) + r.length_low[0],
                               static_cast<double>(r.length_high[1]) + r.length_low[1],
                               static_cast<double>(r.length_high[2]) + r.length_low[2]);
  const Eigen::Matrix3d axes = q.normalized().toRotationMatrix() * length.asDiagonal();
  return outer_box({r.position[0], r.position[1], r.position[2]}, axes.rowwise().norm());
}

}  // namespace

void RecordCollector::add(const GaussianScene& scene) {
  const std::size_t blocks = (scene.size() + kBlock - 1) / kBlock;
  std::vector<FilterReport> reports(blocks);
  std::vector<std::vector<GaussianRecord>> kept(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    kept[b].reserve(kBlock);
    for (std::size_t i = b * kBlock; i < std::min(scene.size(), (b + 1) * kBlock); ++i) {
      const Gaussian activated = scene.gaussian(i);
      if (keeps(scene, i, activated, filter_, world_from_scene_, reports[b])) {
        kept[b].push_back(record_of(scene, i, activated, filter_));
      }
    }
  });

  std::vector<std::size_t> first(blocks);
  std::size_t size = records_.size();
  for (std::size_t b = 0; b < blocks; ++b) {
    first[b] = size;
    size += kept[b].size();
    report_ += reports[b];
  }
  records_.resize(size);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    std::copy(kept[b].begin(), kept[b].end(), records_.begin() + static_cast<std::ptrdiff_t>(first[b]));
  });
}

std::vector<Eigen::AlignedBox3f> boxes_of(std::span<const GaussianRecord> records) {
  std::vector<Eigen::AlignedBox3f> boxes(records.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, records.size(), kBlock), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) boxes[i] = box_of(records[i]);
  });
  return boxes;
}

}  // namespace palpate
