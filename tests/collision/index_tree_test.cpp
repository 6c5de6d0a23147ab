// The tree of a SceneIndex: whole, sound, not too deep, and the same whoever builds it.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <palpate/collision/index_builder.h>
#include <palpate/collision/record_collector.h>
#include <palpate/collision/scene_index.h>
#include <support/effort.h>
#include <support/index_check.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using test::draws;
using test::expect_valid;
using test::scene_of;
using test::sphere_of_splats;
using test::splat;
using test::Splat;
using test::wild_splat;
using test::with_gaps_in_ids;

template <typename T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void expect_same(const IndexView& a, const IndexView& b) {
  EXPECT_TRUE(same_bytes(a.nodes, b.nodes));
  EXPECT_TRUE(same_bytes(a.blocks, b.blocks));
}

TEST(IndexTree, OfAnyNumberOfGaussiansIsValid) {
  test::Random random(101);
  for (const std::size_t n : {1U, 2U, 15U, 16U, 17U, 31U, 32U, 33U, 255U, 256U, 257U, 4095U, 4097U, 30000U}) {
    SCOPED_TRACE(n);
    const GaussianScene scene = with_gaps_in_ids(scene_of(sphere_of_splats(random, n)));
    const SceneIndex index(scene, {}, {});
    expect_valid(index.view(), scene);
    EXPECT_EQ(index.view().blocks.size(), (n + 15) / 16) << "full blocks";
    EXPECT_EQ(index.size(), n);
    EXPECT_EQ(index.bytes(), 448 * index.view().nodes.size() + 1024 * index.view().blocks.size());
  }
}

// A tree over 16 x 16 Gaussians has 16 blocks, which one node holds.
TEST(IndexTree, IsAsFlatAsItCanBe) {
  test::Random random(102);
  const GaussianScene few = scene_of(sphere_of_splats(random, 256));
  EXPECT_EQ(expect_valid(SceneIndex(few, {}, {}).view(), few), 1U);
  const GaussianScene more = scene_of(sphere_of_splats(random, 20000));  // 1250 blocks: three levels are 4096
  EXPECT_LE(expect_valid(SceneIndex(more, {}, {}).view(), more), 8U);
}

TEST(IndexTree, OfWildSizesIsValid) {
  test::Random random(103);
  std::vector<Splat> splats;
  for (int i = 0; i < 5000; ++i) splats.push_back(wild_splat(random, 100.0));
  const GaussianScene scene = scene_of(splats);
  expect_valid(SceneIndex(scene, {}, {}).view(), scene);
  SceneFilter filter;
  filter.sigma = 3.0;
  expect_valid(SceneIndex(scene, filter, {}).view(), scene, filter);
  filter.iso = 0.3;
  expect_valid(SceneIndex(scene, filter, {}).view(), scene, filter);
}

TEST(IndexTree, WithMipSplattingsFilterIsValid) {
  test::Random random(104);
  for (const std::size_t n : {20U, 400U, 3000U, 40000U}) {
    GaussianScene scene = scene_of(sphere_of_splats(random, n));
    for (std::size_t i = 0; i < n; ++i)
      scene.filter_3d.push_back(static_cast<float>(random.log_uniform(1e-5, 0.01)));
    expect_valid(SceneIndex(scene, {}, {}).view(), scene);
  }
}

TEST(IndexTree, FarFromItsOriginIsValid) {
  test::Random random(105);
  std::vector<Splat> splats = sphere_of_splats(random, 5000);
  for (Splat& s : splats) s.position += Eigen::Vector3d(1e6, -1e6, 1e9);
  GaussianScene scene = scene_of(splats);
  scene.origin = {4.5e6, 5.4e6, 3e2};
  expect_valid(SceneIndex(scene, {}, {}).view(), scene);
}

double half_area(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d size = high - low;
  return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

/// Of the boxes of all blocks.
double leaf_area(const IndexView& view) {
  double sum = 0.0;
  for (const IndexNode& node : view.nodes) {
    for (std::size_t k = 0; k < kIndexWidth; ++k) {
      if ((node.child[k] & IndexNode::kLeaf) == 0 || node.low[0][k] > node.high[0][k]) continue;
      sum += half_area({node.low[0][k], node.low[1][k], node.low[2][k]},
                       {node.high[0][k], node.high[1][k], node.high[2][k]});
    }
  }
  return sum;
}

/// The same where the centres are halved along the longest side of their box. \param balls of radius sigma[0]
double halved_area(std::span<Splat> balls) {
  Eigen::Vector3d low = balls[0].position, high = low, from = low, to = low;
  for (const Splat& ball : balls) {
    const Eigen::Vector3d reach = ball.sigma;
    low = low.cwiseMin(ball.position - reach);
    high = high.cwiseMax(ball.position + reach);
    from = from.cwiseMin(ball.position);
    to = to.cwiseMax(ball.position);
  }
  if (balls.size() <= kIndexWidth) return half_area(low, high);
  Eigen::Index axis = 0;
  (to - from).maxCoeff(&axis);
  const auto middle = balls.begin() + static_cast<std::ptrdiff_t>(balls.size() / 2);
  std::nth_element(balls.begin(), middle, balls.end(),
                   [axis](const Splat& a, const Splat& b) { return a.position[axis] < b.position[axis]; });
  return halved_area({balls.begin(), middle}) + halved_area({middle, balls.end()});
}

// What a query has to look at goes with the area of boxes (Goldsmith and Salmon 1987): where sizes differ,
// and the scene is far longer than wide and to one side of its origin, halving is no match.
TEST(IndexTree, HasLessThanHalfTheAreaThatHalvingHas) {
  test::Random random(106);
  std::vector<Splat> balls;
  for (int k = 0; k < 16 * 1024; ++k) {
    const double radius = k % 20 == 0 ? random.log_uniform(0.1, 1.0) : 0.01;
    const Eigen::Vector3d at = random.in_box(0.5);
    balls.push_back(
        splat({30.0 + 20.0 * at.x(), 3.0 + 2.0 * at.y(), at.z()}, Eigen::Vector3d::Constant(radius)));
  }
  EXPECT_LT(leaf_area(SceneIndex(scene_of(balls), {}, {}).view()), 0.5 * halved_area(balls));
}

// Nothing tells these apart: the builder may not look for a plane that does, nor dig a level for each.
TEST(IndexTree, OfEqualGaussiansIsFlat) {
  const GaussianScene scene = scene_of(std::vector<Splat>(20000, splat({1, 2, 3}, {0.1, 0.2, 0.3})));
  EXPECT_LE(expect_valid(SceneIndex(scene, {}, {}).view(), scene), 12U);
}

// Every split by area takes a few of many off one end, again and again: a spiral of sizes, centres at 2^-k.
TEST(IndexTree, OfGeometricSizesIsNotTooDeep) {
  for (const double base : {0.5, 0.7, 0.9, 0.99}) {
    std::vector<Splat> splats;
    for (std::size_t k = 0; k < draws(50000); ++k) {
      const double s = std::max(1e-30, std::pow(base, static_cast<double>(k % 4000)));
      splats.push_back(splat({s, -s, s * s}, {s, 0.1 * s, 0.01 * s}));
    }
    const GaussianScene scene = scene_of(splats);
    EXPECT_LE(expect_valid(SceneIndex(scene, {}, {}).view(), scene), kMaxIndexDepth);
  }
}

TEST(IndexTree, IsTheSameOnAnyNumberOfThreads) {
  test::Random random(106);
  const GaussianScene scene = scene_of(sphere_of_splats(random, 100000));  // enough for parallel branches
  const SceneIndex reference(scene, {}, {});
  for (const std::size_t threads : {1U, 2U, 3U, 8U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    for (int i = 0; i < 3; ++i) expect_same(SceneIndex(scene, {}, {}).view(), reference.view());
  }
}

// The index is in the captured frame: moving the scene changes where the tool is, not the tree.
TEST(IndexTree, DoesNotDependOnTheRegistration) {
  test::Random random(107);
  const GaussianScene scene = scene_of(sphere_of_splats(random, 2000));
  const Similarity world{0.42, Eigen::Quaterniond(0.5, -0.7, 0.1, 0.3).normalized(), {3.25, -41.5, 1.125}};
  const SceneIndex moved(scene, {}, world);
  expect_same(SceneIndex(scene, {}, {}).view(), moved.view());
}

TEST(IndexTree, HoldsWhatTheFilterKeeps) {
  test::Random random(108);
  GaussianScene scene = with_gaps_in_ids(scene_of(sphere_of_splats(random, 3000)));
  for (std::size_t i = 0; i < scene.size(); i += 7)
    scene.position[i][1] = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < scene.size(); i += 11) scene.scale[i].setZero();
  for (std::size_t i = 0; i < scene.size(); i += 13) scene.rotation[i].setZero();
  SceneFilter filter;
  filter.opacity_min = 0.5;
  filter.max_scale = 0.03;
  filter.crop_sphere = SceneFilter::Sphere{{0.5, 0, 0}, 1.0};
  const SceneIndex index(scene, filter, {});
  expect_valid(index.view(), scene, filter);
  EXPECT_GT(index.size(), 100U);
  EXPECT_LT(index.size(), 2000U);
}

TEST(IndexTree, CopiesShareTheMemory) {
  test::Random random(109);
  const SceneIndex index(scene_of(sphere_of_splats(random, 100)), {}, {});
  const SceneIndex copy = index;
  EXPECT_EQ(copy.view().blocks.data(), index.view().blocks.data());
}

TEST(IndexTree, ReportsProgressUpToOne) {
  test::Random random(110);
  std::vector<double> fractions;
  const SceneIndex index(scene_of(sphere_of_splats(random, 100)), {}, {},
                         [&](std::string_view stage, double fraction) {
                           EXPECT_EQ(stage, "indexing");
                           fractions.push_back(fraction);
                         });
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

// Trees of parts under one root, as scenes larger than kMaxTreeRecords have them.
class IndexForestOf : public testing::TestWithParam<std::size_t> {};

INSTANTIATE_TEST_SUITE_P(Trees, IndexForestOf, testing::Values(1, 2, 15, 16, 17, 100, 300));

TEST_P(IndexForestOf, IsATree) {
  test::Random random(111);
  constexpr std::size_t kPart = 40;
  const GaussianScene scene = with_gaps_in_ids(scene_of(sphere_of_splats(random, kPart * GetParam())));
  RecordCollector collector({}, {});
  collector.add(scene);
  const std::span<const GaussianRecord> records = collector.records();
  ASSERT_EQ(records.size(), scene.size());
  IndexForest forest;
  std::vector<GaussianBlock> blocks;
  for (std::size_t part = 0; part < GetParam(); ++part) {
    const auto some = records.subspan(kPart * part, kPart);
    const std::vector<GaussianBlock> next = forest.plant(build_tree(some, boxes_of(some)));
    blocks.insert(blocks.end(), next.begin(), next.end());
  }
  const std::vector<IndexNode> nodes = forest.join();
  IndexView view;
  view.nodes = nodes;
  view.blocks = blocks;
  view.gaussians = scene.size();
  expect_valid(view, scene);
}

}  // namespace
}  // namespace palpate
