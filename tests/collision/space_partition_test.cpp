// What an index larger than memory is cut with: sample, partition, spill, and all of them together.

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/index_storage.h>
#include <palpate/collision/record_collector.h>
#include <palpate/collision/record_spill.h>
#include <palpate/collision/scene_index.h>
#include <palpate/collision/space_partition.h>
#include <support/brute_force.h>
#include <support/index_check.h>
#include <support/random_scenes.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

GaussianRecord record_at(const Eigen::Vector3f& p, std::uint32_t id) {
  GaussianRecord record{};
  record.position = {p[0], p[1], p[2]};
  record.rotation = {1, 0, 0, 0};
  record.id = id;
  return record;
}

std::vector<GaussianRecord> records_at(const std::vector<Eigen::Vector3f>& positions) {
  std::vector<GaussianRecord> records;
  for (const Eigen::Vector3f& p : positions)
    records.push_back(record_at(p, static_cast<std::uint32_t>(records.size())));
  return records;
}

TEST(PositionSample, IsEvenAndBounded) {
  PositionSample at_once, by_parts;
  std::vector<GaussianRecord> records(1'000'000);
  for (std::size_t i = 0; i < records.size(); ++i) records[i].position = {static_cast<float>(i), 0.0F, 0.0F};
  at_once.add(records);
  const std::span<const GaussianRecord> all = records;
  for (std::size_t first = 0, n = 1; first < all.size(); first += n, n = n * 3 % 7919 + 1)
    by_parts.add(all.subspan(first, std::min(n, all.size() - first)));
  EXPECT_EQ(at_once.seen(), records.size());
  EXPECT_EQ(by_parts.seen(), records.size());
  const auto& positions = at_once.positions();
  EXPECT_LT(positions.size(), 1U << 18);
  EXPECT_GT(positions.size(), 1U << 17);
  const float stride = positions[1][0];
  for (std::size_t i = 0; i < positions.size(); ++i)
    ASSERT_EQ(positions[i][0], stride * static_cast<float>(i));
  EXPECT_TRUE(positions == by_parts.positions());
}

TEST(PositionSample, OfAFewHasAllOfThem) {
  PositionSample sample;
  sample.add(records_at({{1, 2, 3}, {4, 5, 6}}));
  sample.add({});
  EXPECT_EQ(sample.seen(), 2U);
  ASSERT_EQ(sample.positions().size(), 2U);
  EXPECT_EQ(sample.positions()[1], Eigen::Vector3f(4, 5, 6));
}

/// Expects parts of at most `most`, none empty, each in a box that no other's meets.
void expect_partition(const std::vector<Eigen::Vector3f>& positions, std::size_t most) {
  const SpacePartition partition(positions, positions.size(), most);
  std::vector<std::size_t> count(partition.parts());
  std::vector<Eigen::AlignedBox3f> box(partition.parts());
  for (const Eigen::Vector3f& p : positions) {
    const std::size_t part = partition.part_of({p[0], p[1], p[2]});
    ASSERT_LT(part, partition.parts());
    ++count[part];
    box[part].extend(p);
  }
  for (std::size_t a = 0; a < count.size(); ++a) {
    EXPECT_GE(count[a], 1U);
    EXPECT_TRUE(count[a] <= most || box[a].sizes().isZero(0.0F)) << count[a] << " in part " << a;
    for (std::size_t b = 0; b < a; ++b) EXPECT_TRUE(box[a].intersection(box[b]).isEmpty()) << a << ", " << b;
  }
  EXPECT_LE(partition.parts(), 4 * (positions.size() / most + 1)) << "needlessly many";
}

TEST(SpacePartition, CutsACloudIntoPartsOfBoundedSize) {
  test::Random random(501);
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 20000; ++i) positions.push_back(random.in_box(3.0).cast<float>());
  expect_partition(positions, 1000);
  expect_partition(positions, 20000);
  EXPECT_EQ(SpacePartition(positions, positions.size(), 20000).parts(), 1U);
  EXPECT_GE(SpacePartition(positions, positions.size(), 19999).parts(), 2U);
}

// Positions that planes cannot tell apart are one part, however many they are; the others still are bounded.
TEST(SpacePartition, CutsAroundPositionsThatAreEqual) {
  test::Random random(502);
  std::vector<Eigen::Vector3f> positions(5000, Eigen::Vector3f(1, 2, 3));
  expect_partition(positions, 100);
  EXPECT_EQ(SpacePartition(positions, positions.size(), 100).parts(), 1U);
  for (int i = 0; i < 3000; ++i) positions.push_back(random.in_box(3.0).cast<float>());
  expect_partition(positions, 100);
  for (int i = 0; i < 3000; ++i) positions.emplace_back(0.0F, 0.0F, static_cast<float>(i % 3));
  expect_partition(positions, 100);
}

TEST(SpacePartition, CutsALineAndAGrid) {
  std::vector<Eigen::Vector3f> line, grid;
  for (int i = 0; i < 4000; ++i) line.emplace_back(1.0F, static_cast<float>(i), 1.0F);
  for (int i = 0; i < 4000; ++i)
    grid.emplace_back(static_cast<float>(i % 4), static_cast<float>(i / 4 % 10), static_cast<float>(i / 40));
  expect_partition(line, 100);
  expect_partition(grid, 100);
}

// The sample stands for a scene of which it is a hundredth.
TEST(SpacePartition, BoundsTheSceneThatASampleStandsFor) {
  test::Random random(503);
  std::vector<Eigen::Vector3f> positions, sample;
  for (int i = 0; i < 200'000; ++i) {
    positions.push_back(random.in_box(1.0).cast<float>());
    if (i % 10 == 0) sample.push_back(positions.back());
  }
  const SpacePartition partition(sample, positions.size(), 20'000);
  std::vector<std::size_t> count(partition.parts());
  for (const Eigen::Vector3f& p : positions) ++count.at(partition.part_of({p[0], p[1], p[2]}));
  EXPECT_GE(partition.parts(), 10U);
  EXPECT_LE(*std::max_element(count.begin(), count.end()), 22'000U);
}

TEST(SpacePartition, HasAPlaceForWhatTheSampleDoesNotShow) {
  const std::vector<Eigen::Vector3f> sample{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const SpacePartition partition(sample, 4, 1), of_nothing({}, 0, 1);
  EXPECT_EQ(partition.parts(), 4U);
  constexpr float kFar = std::numeric_limits<float>::max();
  EXPECT_EQ(partition.part_of({-kFar, 0, 0}), partition.part_of({0, 0, 0}));
  EXPECT_EQ(partition.part_of({kFar, kFar, -kFar}), partition.part_of({3, 0, 0}));
  EXPECT_EQ(of_nothing.parts(), 1U);
  EXPECT_EQ(of_nothing.part_of({1, 2, 3}), 0U);
}

TEST(RecordSpill, GivesBackEveryRecordInItsPartInOrder) {
  test::Random random(504);
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 120'000; ++i)
    positions.push_back(random.in_box(1.0).cast<float>());  // several extents a part
  positions.insert(positions.end(), 50'000, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  const std::vector<GaussianRecord> records = records_at(positions);
  const SpacePartition partition(positions, positions.size(), 60'000);
  ASSERT_GE(partition.parts(), 3U);
  const test::TemporaryFile beside("x");
  RecordSpill spill(beside.folder().string(), partition);
  const std::span<const GaussianRecord> all = records;
  for (std::size_t first = 0; first < all.size(); first += 777)
    spill.add(all.subspan(first, std::min<std::size_t>(777, all.size() - first)));
  std::vector<std::vector<GaussianRecord>> expected(partition.parts());
  for (const GaussianRecord& r : records) expected[partition.part_of(r.position)].push_back(r);
  for (std::size_t part = 0; part < partition.parts(); ++part) {
    const std::vector<GaussianRecord> read = spill.read(part);
    ASSERT_EQ(read.size(), expected[part].size());
    EXPECT_EQ(std::memcmp(read.data(), expected[part].data(), read.size() * sizeof(GaussianRecord)), 0);
    EXPECT_EQ(spill.read(part).size(), read.size()) << "once more";
  }
}

/// An index built as a scene of a hundred million is: in parts, from records that were on disk.
std::shared_ptr<const IndexArrays> build_in_parts(const GaussianScene& scene, std::size_t most) {
  RecordCollector collector({}, {});
  collector.add(scene);
  PositionSample sample;
  sample.add(collector.records());
  const SpacePartition partition(sample.positions(), sample.seen(), most);
  const test::TemporaryFile beside("x");
  RecordSpill spill(beside.folder().string(), partition);
  spill.add(collector.records());
  const auto arrays = std::make_shared<IndexArrays>();
  IndexForest forest;
  for (std::size_t part = 0; part < partition.parts(); ++part) {
    plant(spill.read(part), forest, [&](const std::vector<GaussianBlock>& blocks) {
      arrays->blocks.insert(arrays->blocks.end(), blocks.begin(), blocks.end());
    });
  }
  arrays->nodes = forest.join();
  arrays->gaussians = sample.seen();
  return arrays;
}

TEST(IndexInParts, FindsWhatAnIndexBuiltAtOnceFinds) {
  test::Random random(505);
  const GaussianScene scene = test::with_gaps_in_ids(test::scene_of(sphere_of_splats(random, 20000)));
  const test::BruteForce truth(scene, {}, {}, tools_at_sphere(random, 100));
  for (const std::size_t most : {100U, 1000U, 7000U, 20000U}) {
    SCOPED_TRACE(most);
    const auto arrays = build_in_parts(scene, most);
    test::expect_valid(arrays->view(), scene);
    EXPECT_GT(truth.check(SceneIndex(arrays, {})), 500U);
  }
}

}  // namespace
}  // namespace palpate
