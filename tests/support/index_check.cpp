#include <support/index_check.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

using Box = Eigen::AlignedBox3d;

Box slot_box(const IndexNode& node, std::size_t slot) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min()[static_cast<int>(axis)] = node.low[axis][slot];
    box.max()[static_cast<int>(axis)] = node.high[axis][slot];
  }
  return box;
}

bool is_aligned(const void* address) { return reinterpret_cast<std::uintptr_t>(address) % 64 == 0; }

class Walk {
 public:
  Walk(const IndexView& view, const GaussianScene& scene, const SceneFilter& filter)
      : view_(view), scene_(scene), node_seen_(view.nodes.size()), block_seen_(view.blocks.size()) {
    FilterReport report;
    kept_ = filter_scene(scene, filter, {}, report);
    for (std::size_t i = 0; i < scene.size(); ++i) row_[scene.id[i]] = i;
  }

  std::size_t run() {
    if (!view_.nodes.empty())
      node(0, 1, Box(Eigen::Vector3d::Constant(-1e30), Eigen::Vector3d::Constant(1e30)));
    EXPECT_EQ(std::count(node_seen_.begin(), node_seen_.end(), 1), std::ssize(node_seen_));
    EXPECT_EQ(std::count(block_seen_.begin(), block_seen_.end(), 1), std::ssize(block_seen_));
    std::sort(ids_.begin(), ids_.end());
    EXPECT_EQ(ids_, kept_.id);
    EXPECT_EQ(view_.gaussians, kept_.size());
    return depth_;
  }

 private:
  void node(std::size_t n, std::size_t depth, const Box& outer) {
    ASSERT_LT(n, view_.nodes.size());
    ASSERT_LE(depth, kMaxIndexDepth);
    ASSERT_EQ(++node_seen_[n], 1);
    depth_ = std::max(depth_, depth);
    for (std::size_t slot = 0; slot < kIndexWidth; ++slot) {
      const IndexNode& self = view_.nodes[n];
      const Box box = slot_box(self, slot);
      if (box.isEmpty()) {
        EXPECT_TRUE((box.min().array() > box.max().array()).all()) << "empty along every axis";
        continue;
      }
      ASSERT_TRUE(outer.contains(box)) << "node " << n << ", slot " << slot;
      const std::uint32_t child = self.child[slot];
      if ((child & IndexNode::kLeaf) != 0) {
        block(child & ~IndexNode::kLeaf, box);
      } else {
        node(child, depth + 1, box);
      }
      if (testing::Test::HasFatalFailure()) return;
    }
  }

  void block(std::size_t b, const Box& box) {
    ASSERT_LT(b, view_.blocks.size());
    ASSERT_EQ(++block_seen_[b], 1);
    const GaussianBlock& block = view_.blocks[b];
    std::size_t filled = 0;
    for (; filled < kIndexWidth && !std::isnan(block.position[0][filled]); ++filled) {
      if (filled > 0) {
        EXPECT_LT(block.id[filled - 1], block.id[filled]);
      }
      ids_.push_back(block.id[filled]);
      gaussian(b, filled, box);
    }
    EXPECT_GT(filled, 0U);
    for (; filled < kIndexWidth; ++filled) {
      for (const Lanes16<float>& lane : block.position) EXPECT_TRUE(std::isnan(lane[filled]));
    }
  }

  void gaussian(std::size_t b, std::size_t lane, const Box& box) {
    const GaussianBlock& block = view_.blocks[b];
    const auto row = row_.find(block.id[lane]);
    ASSERT_NE(row, row_.end());
    const std::size_t i = row->second;
    const auto kept = std::lower_bound(kept_.id.begin(), kept_.id.end(), block.id[lane]) - kept_.id.begin();
    const Ellipsoid& e = kept_.ellipsoids[static_cast<std::size_t>(kept)];
    constexpr double kTwoFloats = 0x1p-47;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto n = static_cast<int>(k);
      ASSERT_EQ(block.position[k][lane], scene_.position[i][n]);
      const double length = static_cast<double>(block.length_high[k][lane]) + block.length_low[k][lane];
      ASSERT_NEAR(length, e.axes.col(n).norm(), kTwoFloats * length);
    }
    for (std::size_t k = 0; k < 4; ++k)
      ASSERT_EQ(block.rotation[k][lane], scene_.rotation[i][static_cast<int>(k)]);
    const double opacity = static_cast<double>(block.opacity_high[lane]) + block.opacity_low[lane];
    ASSERT_NEAR(opacity, kept_.opacity[static_cast<std::size_t>(kept)], kTwoFloats * opacity);

    const Eigen::Vector3d center = scene_.position[i].cast<double>(), half = e.half_extents();
    EXPECT_TRUE(box.contains(center - half) && box.contains(center + half)) << "id " << block.id[lane];
  }

  const IndexView& view_;
  const GaussianScene& scene_;
  EllipsoidScene kept_;
  std::map<std::uint32_t, std::size_t> row_;  ///< by id
  std::vector<int> node_seen_, block_seen_;
  std::vector<std::uint32_t> ids_;
  std::size_t depth_ = 0;
};

}  // namespace

std::size_t expect_valid(const IndexView& view, const GaussianScene& scene, const SceneFilter& filter) {
  EXPECT_TRUE(is_aligned(view.nodes.data()) && is_aligned(view.blocks.data()));
  EXPECT_EQ(view.origin, scene.origin);
  return Walk(view, scene, filter).run();
}

}  // namespace palpate::test
