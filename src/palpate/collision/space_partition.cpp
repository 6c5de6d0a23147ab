#include <palpate/collision/space_partition.h>

#include <algorithm>

namespace palpate {

void PositionSample::add(std::span<const GaussianRecord> records) {
  for (const GaussianRecord& r : records) {
    if (seen_++ % stride_ != 0) continue;
    positions_.emplace_back(r.position[0], r.position[1], r.position[2]);
    if (positions_.size() < kMost) continue;
    for (std::size_t i = 0; 2 * i < positions_.size(); ++i) positions_[i] = positions_[2 * i];
    positions_.resize(positions_.size() / 2);
    stride_ *= 2;
  }
}

SpacePartition::SpacePartition(std::vector<Eigen::Vector3f> sample, std::uint64_t total, std::size_t most) {
  const double weight =
      static_cast<double>(total) / static_cast<double>(std::max<std::size_t>(1, sample.size()));
  split(sample, weight, most);
}

void SpacePartition::split(std::span<Eigen::Vector3f> sample, double weight, std::size_t most) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : sample) box.extend(p);
  const std::size_t self = nodes_.size();
  int axis = 0;
  const bool fits = static_cast<double>(sample.size()) * weight <= static_cast<double>(most);
  if (fits || box.sizes().maxCoeff(&axis) == 0.0F) {  // or cannot be separated
    nodes_.push_back({0.0F, 3, static_cast<std::uint32_t>(parts_++)});
    return;
  }
  const auto below = [axis](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a[axis] < b[axis]; };
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end(), below);
  float plane = (*middle)[axis];
  if (plane == box.min()[axis]) {  // half of the sample shares it: cut above, else the lower part is empty
    plane = box.max()[axis];
    for (const Eigen::Vector3f& p : sample) {
      if (p[axis] > box.min()[axis]) plane = std::min(plane, p[axis]);
    }
  }
  const auto right =
      std::partition(sample.begin(), sample.end(), [&](const Eigen::Vector3f& p) { return p[axis] < plane; });
  nodes_.push_back({plane, static_cast<std::uint32_t>(axis), 0});
  const auto left_size = static_cast<std::size_t>(right - sample.begin());
  split(sample.first(left_size), weight, most);
  nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
  split(sample.subspan(left_size), weight, most);
}

std::size_t SpacePartition::part_of(const std::array<float, 3>& position) const {
  const Node* node = nodes_.data();
  while (node->axis < 3) node = position[node->axis] < node->plane ? node + 1 : nodes_.data() + node->right;
  return node->right;
}

}  // namespace palpate
