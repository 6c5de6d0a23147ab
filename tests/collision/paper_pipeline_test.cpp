// PaperPipeline against a loop over all Gaussians: what it finds, and what it is known to miss.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/paper_pipeline.h>
#include <support/brute_force.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using test::brute_force;
using test::random_tools;

/// Ids that are not positions, as after a filter: 3 i + 5.
EllipsoidScene ellipsoid_scene(std::vector<Ellipsoid> ellipsoids) {
  EllipsoidScene scene;
  for (std::size_t i = 0; i < ellipsoids.size(); ++i) {
    scene.opacity.push_back(0.1 + 0.9 * static_cast<double>(i % 97) / 97.0);
    scene.id.push_back(static_cast<std::uint32_t>(3 * i + 5));
  }
  scene.ellipsoids = std::move(ellipsoids);
  return scene;
}

Ellipsoid wild(test::Random& r, double half) {
  const Pose pose{r.in_box(half), r.rotation()};
  return Ellipsoid::from_semi_axes(pose, test::wild_semi_axes(r));
}

/// Golden section stops with a bracket 0.618^30 wide, half of which it may be off; K is flat there, by at
/// most its second derivative, which the end of the range bounds only for lambda away from 0 and 1.
constexpr double kGoldenSection = 1e-6;

TEST(PaperPipeline, WithARadiusThatCoversAll_vs_bruteforce) {
  test::Random random(82);
  std::vector<Ellipsoid> ellipsoids;
  for (int i = 0; i < 3000; ++i) ellipsoids.push_back(random.ellipsoid(0.3, 0.01, 0.1));
  const EllipsoidScene scene = ellipsoid_scene(ellipsoids);
  const PaperPipeline pipeline(scene, 10.0);
  ContactSet set;
  std::size_t seen = 0;
  for (const Ellipsoid& tool : random_tools(random, 100, 0.4, 0.02, 0.1)) {
    pipeline.query(tool, set);
    const std::vector<Contact> truth = brute_force(scene, tool);
    EXPECT_EQ(set.candidates, scene.size());
    ASSERT_EQ(set.contacts.size(), truth.size());  // none of these has |K_min| < 1e-6
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(set.contacts[i].id, truth[i].id);
      EXPECT_NEAR(set.contacts[i].k_min, truth[i].k_min, 1e-11);
      EXPECT_GE(set.contacts[i].k_min, truth[i].k_min - 1e-14);  // a search cannot go below the minimum
      EXPECT_NEAR(set.contacts[i].lambda, truth[i].lambda, kGoldenSection);
      EXPECT_EQ(set.contacts[i].opacity, truth[i].opacity);
      EXPECT_LE((set.contacts[i].normal - truth[i].normal).norm(), 1e-3);
    }
    seen += truth.size();
  }
  EXPECT_GT(seen, 500U);
}

TEST(PaperPipeline, MissesWhatIsOutOfReachAndNothingElse) {
  test::Random random(83);
  std::vector<Ellipsoid> ellipsoids;
  for (int i = 0; i < 3000; ++i) {
    const Pose pose{random.in_box(0.5), random.rotation()};
    const double size = random.log_uniform(0.005, 0.4);
    ellipsoids.push_back(Ellipsoid::from_semi_axes(pose, size * random.semi_axes(0.3, 1.0)));
  }
  const EllipsoidScene scene = ellipsoid_scene(ellipsoids);
  const double radius = 0.15;
  const PaperPipeline pipeline(scene, radius);
  EXPECT_EQ(pipeline.search_radius(), radius);
  ContactSet set;
  std::size_t most_missed = 0;
  for (const Ellipsoid& tool : random_tools(random, 100, 0.5, 0.02, 0.1)) {
    pipeline.query(tool, set);
    std::vector<std::uint32_t> expected, found;
    std::size_t missed = 0, in_reach = 0;
    for (const Contact& c : brute_force(scene, tool)) {
      if ((c.center - tool.center).norm() < radius) {
        expected.push_back(c.id);
      } else {
        ++missed;
      }
    }
    for (const Ellipsoid& e : scene.ellipsoids) in_reach += (e.center - tool.center).norm() < radius;
    for (const Contact& c : set.contacts) found.push_back(c.id);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(set.candidates, in_reach);
    EXPECT_LE(missed, pipeline.can_miss(tool.radius()));
    most_missed = std::max(most_missed, missed);
  }
  EXPECT_GT(most_missed, 10U);
}

TEST(PaperPipeline, CanMissByHand) {
  const auto ball = [](double r) -> Ellipsoid { return {{0, 0, 0}, r * Eigen::Matrix3d::Identity()}; };
  const PaperPipeline pipeline(ellipsoid_scene({ball(0.125), ball(0.25), ball(0.5), ball(1.0)}), 0.75);
  EXPECT_EQ(pipeline.can_miss(0.5), 2U);  // 0.25 + 0.5 just reaches
  EXPECT_EQ(pipeline.can_miss(0.0), 1U);
  EXPECT_EQ(pipeline.can_miss(0.625), 3U);  // 0.125 + 0.625 just reaches
  EXPECT_EQ(pipeline.can_miss(10.0), 4U);
}

TEST(PaperPipeline, DefaultRadiusLeavesAtMostOnePercentOut) {
  test::Random random(84);
  for (const std::size_t n : {1U, 7U, 99U, 100U, 101U, 1000U, 5000U}) {
    std::vector<Ellipsoid> ellipsoids;
    for (std::size_t i = 0; i < n; ++i) ellipsoids.push_back(wild(random, 1.0));
    const EllipsoidScene scene = ellipsoid_scene(ellipsoids);
    const double radius = PaperPipeline::default_search_radius(scene, 0.04);
    const PaperPipeline pipeline(scene, radius);
    EXPECT_LE(pipeline.can_miss(0.04), (n + 99) / 100) << n;
    if (n >= 1000) {
      EXPECT_GE(pipeline.can_miss(0.04), n / 100 - 1) << n;
    }
  }
  EXPECT_EQ(PaperPipeline::default_search_radius({}, 0.04), 0.04);
}

TEST(PaperPipeline, OfNothingIsNeverTouched) {
  const PaperPipeline pipeline(EllipsoidScene{}, 1.0);
  ContactSet set;
  set.candidates = 7;
  pipeline.query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
  EXPECT_TRUE(set.contacts.empty());
  EXPECT_EQ(set.candidates + set.filtered, 0U);
  EXPECT_EQ(pipeline.can_miss(100.0), 0U);
}

// Its second fault: the minimum for a ball on a small point is at lambda = 1, where golden section does not
// get to. It is off by the last bracket.
TEST(PaperPipeline, DoesNotResolveAMinimumAtOne) {
  const EllipsoidScene scene = ellipsoid_scene({{{0.5, 0, 0}, Eigen::Matrix3d::Zero()}});
  ContactSet set;
  PaperPipeline(scene, 10.0).query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
  ASSERT_EQ(set.contacts.size(), 1U);
  EXPECT_GT(set.contacts[0].k_min, 0.75 + 1e-9);
  EXPECT_LT(set.contacts[0].k_min, 0.75 + 1e-6);
  PaperPipeline(scene, 10.0, 5).query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
  ASSERT_EQ(set.contacts.size(), 1U);
  EXPECT_GT(set.contacts[0].k_min, 0.75 + 1e-3);
}

TEST(PaperPipeline, IsFiniteForAnyNumberOfIterations) {
  test::Random random(85);
  const EllipsoidScene scene = ellipsoid_scene({{{0.5, 0, 0}, Eigen::Matrix3d::Zero()},
                                                {{0, 0.1, 0.2}, Eigen::Vector3d(3, 3, 0).asDiagonal()},
                                                {{0, 0, 0}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()}});
  for (const int iterations : {0, 1, 30, 75, 80, 100, 1000}) {
    ContactSet set;
    PaperPipeline(scene, 10.0, iterations).query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
    EXPECT_EQ(set.contacts.size(), 3U) << iterations;
    for (const Contact& c : set.contacts) {
      EXPECT_TRUE(std::isfinite(c.k_min) && std::isfinite(c.depth)) << iterations;
      EXPECT_TRUE(c.point.allFinite() && c.normal.allFinite()) << iterations;
    }
  }
}

}  // namespace
}  // namespace palpate
