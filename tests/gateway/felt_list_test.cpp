#include <palpate/gateway/felt_list.h>

#include <cstring>
#include <functional>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <support/random_scenes.h>

namespace palpate {
namespace {

/// Semi-axes by row.
using Felt = std::map<std::uint32_t, Eigen::Vector3f>;

/// What a list says, read as its users do.
Felt read(const std::string& bytes) {
  Felt result;
  EXPECT_EQ(bytes.size() % 16, 0U);
  for (std::size_t at = 0; at + 16 <= bytes.size(); at += 16) {
    std::uint32_t row = 0;
    Eigen::Vector3f semi_axes;
    std::memcpy(&row, bytes.data() + at, 4);
    std::memcpy(semi_axes.data(), bytes.data() + at + 4, 12);
    EXPECT_TRUE(result.emplace(row, semi_axes).second) << row << " is there twice";
  }
  return result;
}

/// What filter_scene() makes, brought back to captured units.
Felt expected(const GaussianScene& scene, const SceneFilter& filter, const Similarity& world_from_scene) {
  FilterReport report;
  const EllipsoidScene kept = filter_scene(scene, filter, world_from_scene, report);
  Felt result;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Eigen::Vector3d lengths = kept.ellipsoids[i].axes.colwise().norm();
    result[kept.id[i]] = (lengths / world_from_scene.scale).cast<float>();
  }
  return result;
}

void expect_same(const Felt& felt, const Felt& wanted) {
  ASSERT_EQ(felt.size(), wanted.size());
  for (const auto& [row, semi_axes] : wanted) {
    ASSERT_TRUE(felt.contains(row)) << row;
    EXPECT_LE((felt.at(row) - semi_axes).norm(), 1e-6F * semi_axes.norm()) << row;
  }
}

class FeltListTest : public testing::Test {
 protected:
  FeltListTest() {
    test::Random random(911);
    scene_ = test::scene_of(test::sphere_of_splats(random, 1003));  // the last block is not full
    filter_.opacity_min = 0.4;
  }

  std::shared_ptr<const SceneIndex> index() const {
    return std::make_shared<const SceneIndex>(scene_, filter_, place_);
  }
  /// All that has been asked for so far is done, and then what that asks for.
  void work() {
    for (auto& [work, then] : std::exchange(jobs_, {})) {
      std::thread(std::exchange(work, nullptr)).join();
      then();
    }
  }

  GaussianScene scene_;
  SceneFilter filter_;
  Similarity place_;
  std::vector<std::pair<std::function<void()>, std::function<void()>>> jobs_;
  FeltListMaker maker_{
      [this](auto work, auto then) { jobs_.emplace_back(std::move(work), std::move(then)); }};
};

TEST_F(FeltListTest, HasWhatTheFilterKeepsAsLargeAsItMakesIt) {
  filter_.sigma = 1.7;
  const Felt all = expected(scene_, filter_, place_);
  EXPECT_GT(all.size(), 500U);
  expect_same(read(felt_list(*index())), all);

  place_.scale = 2.0;
  place_.translation = {0.5, 0, 0};
  filter_.iso = 0.3;
  filter_.max_scale = 0.08;
  filter_.crop_sphere = SceneFilter::Sphere{{0.5, 0, 0}, 2.0};
  const Felt some = expected(scene_, filter_, place_);
  EXPECT_GT(some.size(), 100U);
  EXPECT_LT(some.size(), all.size());
  expect_same(read(felt_list(*index())), some);

  filter_.opacity_min = 1.0;
  EXPECT_EQ(felt_list(*index()), "");
}

TEST_F(FeltListTest, IsMadeAnewForOtherGaussiansOnly) {
  EXPECT_EQ(maker_.newest(), nullptr);
  const auto first = index();
  maker_.follow(first);
  EXPECT_EQ(maker_.newest(), nullptr) << "nobody has waited for it";
  work();
  const auto list = maker_.newest();
  ASSERT_NE(list, nullptr);
  EXPECT_EQ(list->bytes, felt_list(*first));
  EXPECT_EQ(list->number, 1U);

  Similarity elsewhere;
  elsewhere.scale = 3.0;
  maker_.follow(std::make_shared<const SceneIndex>(first->registered(elsewhere)));
  work();
  EXPECT_EQ(maker_.newest(), list);

  // The second is overtaken by the third before it is there: the third is what comes in the end.
  filter_.opacity_min = 0.6;
  maker_.follow(index());
  filter_.opacity_min = 0.9;
  const auto last = index();
  maker_.follow(last);
  work();
  work();
  EXPECT_EQ(maker_.newest()->bytes, felt_list(*last));
  EXPECT_EQ(maker_.newest()->number, 3U);
  work();
  EXPECT_EQ(maker_.newest()->number, 3U) << "and nothing more";
}

// The thread that hands over poses must not be the one that gives gigabytes back.
TEST_F(FeltListTest, AnOldIndexGoesElsewhere) {
  const auto here = std::this_thread::get_id();
  std::thread::id gone_on;
  auto old = std::shared_ptr<const SceneIndex>(new SceneIndex(scene_, filter_, place_),
                                               [&](const SceneIndex* index) {
                                                 gone_on = std::this_thread::get_id();
                                                 delete index;
                                               });
  maker_.follow(old);
  work();
  old.reset();
  filter_.opacity_min = 0.6;
  maker_.follow(index());
  work();
  EXPECT_NE(gone_on, std::thread::id()) << "it has gone";
  EXPECT_NE(gone_on, here);
}

}  // namespace
}  // namespace palpate
