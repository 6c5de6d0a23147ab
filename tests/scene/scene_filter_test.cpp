// Which Gaussians are solid, how large they are, and where they stand.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <palpate/scene/scene_filter.h>

#include "support/not_finite.h"
#include "support/splats.h"

namespace palpate::test {
namespace {

std::vector<std::uint32_t> kept_ids(const GaussianScene& scene, const SceneFilter& filter,
                                    const Similarity& registration = {}) {
  FilterReport report;
  return filter_scene(scene, filter, registration, report).id;
}

using Ids = std::vector<std::uint32_t>;

/// 90 degrees about z.
Similarity quarter_turn(double scale = 1.0, const Eigen::Vector3d& t = {0, 0, 0}) {
  return {scale, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ())), t};
}

TEST(SceneFilter, TheOpacityThresholdIsStrict) {
  GaussianScene scene = scene_of({{}, {}, {}});
  scene.opacity = {0.0F, 1e-6F, -1e-6F};  // alpha = 0.5, just above, just below
  SceneFilter filter;
  filter.opacity_min = 0.5;
  EXPECT_EQ(kept_ids(scene, filter), (Ids{1}));

  scene.opacity_encoding = OpacityEncoding::kByte;
  scene.opacity = {51, 52, 255};
  filter.opacity_min = 0.2;  // 51 / 255
  EXPECT_EQ(kept_ids(scene, filter), (Ids{1, 2}));
  filter.opacity_min = 1.0;
  EXPECT_EQ(kept_ids(scene, filter), (Ids{}));
  filter.opacity_min = 0.0;
  scene.opacity[0] = 0;
  EXPECT_EQ(kept_ids(scene, filter), (Ids{1, 2}));
}

TEST(SceneFilter, EveryGaussianIsCountedOnceAtTheFirstRuleThatDropsIt) {
  // Each Gaussian breaks one rule more than the one behind it.
  SceneFilter filter;
  filter.opacity_min = 0.2;
  filter.iso = 0.4;
  filter.max_scale = 1.0;
  filter.crop_box = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1));
  const Eigen::Vector3d outside(5, 0, 0), large(2, 0.1, 0.1);
  GaussianScene scene = scene_of({{outside, large, 0.1},      // 0: made defective below
                                  {outside, large, 0.1},      // 1: low opacity
                                  {outside, large, 0.3},      // 2: below iso
                                  {outside, large, 0.9},      // 3: over max scale
                                  {outside, {1, 1, 1}, 0.9},  // 4: outside
                                  {{0, 0, 0}, {1, 1, 1}, 0.9}});
  scene.rotation[0].setZero();
  FilterReport report;
  const EllipsoidScene kept = filter_scene(scene, filter, {}, report);
  EXPECT_EQ(report.total, 6U);
  EXPECT_EQ(report.defects, (std::array<std::size_t, kDefectCount>{0, 0, 0, 1, 0}));
  EXPECT_EQ(report.defective(), 1U);
  EXPECT_EQ(report.low_opacity, 1U);
  EXPECT_EQ(report.below_iso, 1U);
  EXPECT_EQ(report.over_max_scale, 1U);
  EXPECT_EQ(report.outside_crop, 1U);
  EXPECT_EQ(report.kept, 1U);
  EXPECT_EQ(kept.id, (Ids{5}));
}

/// Gaussians of which each rule of strict_filter() drops some.
GaussianScene mixed_scene(std::size_t count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Splat> splats;
  for (std::size_t k = 0; k < count; ++k)
    splats.push_back({{4 * unit(random) - 2, 0, 0}, {unit(random), 0.1, 0.1}, 0.01 + 0.98 * unit(random)});
  GaussianScene scene = scene_of(splats);
  scene.color.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    scene.color[k] = {static_cast<std::uint8_t>(k % 256), static_cast<std::uint8_t>(k / 256), 0};
    if (k % 13 == 0) scene.position[k].y() = kFloatNan;
    if (k % 17 == 0) scene.scale[k].setZero();
    if (k % 19 == 0) scene.position[k].z() = 1e30F;
  }
  return scene;
}

SceneFilter strict_filter() {
  SceneFilter filter;
  filter.opacity_min = 0.3;
  filter.iso = 0.4;
  filter.max_scale = 0.8;
  filter.crop_sphere = SceneFilter::Sphere{{0, 0, 0}, 1.5};
  return filter;
}

TEST(SceneFilter, CountsAddUpAndIdsStayRowsOnRandomScenes) {
  const GaussianScene scene = mixed_scene(2000);
  const SceneFilter filter = strict_filter();
  FilterReport report;
  const EllipsoidScene kept = filter_scene(scene, filter, {}, report);
  EXPECT_EQ(report.defective() + report.low_opacity + report.below_iso + report.over_max_scale +
                report.outside_crop + report.kept,
            2000U);
  for (const std::size_t n :
       {report.defective(), report.low_opacity, report.below_iso, report.over_max_scale, report.outside_crop})
    EXPECT_GT(n, 50U);
  ASSERT_EQ(kept.size(), report.kept);
  ASSERT_EQ(kept.id.size(), report.kept);
  ASSERT_EQ(kept.color.size(), report.kept);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (i > 0) {
      ASSERT_LT(kept.id[i - 1], kept.id[i]);
    }
    const Gaussian g = scene.gaussian(kept.id[i]);
    ASSERT_EQ(kept.ellipsoids[i].center, g.position);
    ASSERT_EQ(kept.opacity[i], g.opacity);
    ASSERT_EQ(kept.color[i], scene.color[kept.id[i]]);
    ASSERT_EQ(defect(scene, kept.id[i]), Defect::kNone);
    ASSERT_GT(g.opacity, 0.4);
    ASSERT_LE(g.sigma.maxCoeff(), 0.8);
    ASSERT_LE(g.position.norm(), 1.5);
  }
}

TEST(SceneFilter, CropsAreInTheWorldFrameAndIncludeTheirBoundary) {
  // Registered, x = 1 comes to (10, 22, 30).
  const Similarity registration = quarter_turn(2.0, {10, 20, 30});
  const GaussianScene scene = scene_of({{{1, 0, 0}}, {{1.5, 0, 0}}, {{0, 1, 0}}});
  SceneFilter box;
  box.crop_box = Eigen::AlignedBox3d(Eigen::Vector3d(9.999, 22, 29), Eigen::Vector3d(10.001, 22.5, 30));
  EXPECT_EQ(kept_ids(scene, box, registration), (Ids{0}));
  SceneFilter sphere;
  sphere.crop_sphere = SceneFilter::Sphere{{10, 23.5, 30}, 0.5};
  EXPECT_EQ(kept_ids(scene, sphere, registration), (Ids{1}));
  sphere.crop_sphere->radius = 1.5000001;
  EXPECT_EQ(kept_ids(scene, sphere, registration), (Ids{0, 1}));
  sphere.crop_box = box.crop_box;  // both apply
  EXPECT_EQ(kept_ids(scene, sphere, registration), (Ids{0}));
}

TEST(SceneFilter, MaxScaleIsAStandardDeviationInMetres) {
  const GaussianScene scene = scene_of({{{0, 0, 0}, {0.1, 0.5, 0.25}}});
  SceneFilter filter;
  filter.sigma = 3.0;  // does not matter: the rule is about standard deviations
  filter.max_scale = 1.0;
  EXPECT_EQ(kept_ids(scene, filter, quarter_turn(2.0)), (Ids{0}));  // 0.5 * 2 = 1: at most
  filter.max_scale = std::nextafter(1.0, 0.0);
  EXPECT_EQ(kept_ids(scene, filter, quarter_turn(2.0)), (Ids{}));
}

TEST(SceneFilter, SigmaScalesTheEllipsoid) {
  const Gaussian g = scene_of({{{1, 2, 3}, {1, 2, 4}}}).gaussian(0);
  SceneFilter filter;
  filter.sigma = 2.5;
  const Ellipsoid e = world_ellipsoid(g, filter, {});
  EXPECT_EQ(e.center, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(e.axes.isApprox(Eigen::Vector3d(2.5, 5, 10).asDiagonal().toDenseMatrix(), 1e-15));
}

TEST(SceneFilter, IsoIsTheLevelThatSplattingDraws) {
  // alpha exp(-k^2/2) = tau: with alpha = 0.5 and tau = 0.1, k = sqrt(2 ln 5) = 1.7941225779941015.
  const GaussianScene scene = scene_of({{{0, 0, 0}, {1, 1, 1}, 0.5}});
  SceneFilter filter;
  filter.iso = 0.1;
  filter.sigma = 7.0;  // replaced
  const Ellipsoid e = world_ellipsoid(scene.gaussian(0), filter, {});
  EXPECT_NEAR(e.radius(), 1.7941225779941015, 1e-14);
  EXPECT_NEAR(0.5 * std::exp(-0.5 * e.radius() * e.radius()), 0.1, 1e-15);

  filter.iso = 0.5;  // alpha = tau: the level is a point, nothing to touch
  FilterReport report;
  EXPECT_EQ(filter_scene(scene, filter, {}, report).size(), 0U);
  EXPECT_EQ(report.below_iso, 1U);
  filter.iso = std::nextafter(0.5, 0.0);
  EXPECT_EQ(filter_scene(scene, filter, {}, report).size(), 1U);
}

TEST(SceneFilter, RegistersByHand) {
  // c = 2 Rz(90) (1,0,0) + (1,2,3) = (1,4,3); e_x -> e_y, e_y -> -e_x.
  const Gaussian g = scene_of({{{1, 0, 0}, {1, 2, 3}}}).gaussian(0);
  const Ellipsoid e = world_ellipsoid(g, {}, quarter_turn(2.0, {1, 2, 3}));
  EXPECT_TRUE(e.center.isApprox(Eigen::Vector3d(1, 4, 3), 1e-15));
  Eigen::Matrix3d expected;
  expected << 0, -4, 0, 2, 0, 0, 0, 0, 6;
  EXPECT_TRUE(e.axes.isApprox(expected, 1e-15)) << e.axes;
}

TEST(SceneFilter, RegistrationMovesTheSolidAndNothingElse) {
  // Eq. 3 as a property: the support function in any direction n scales and turns with the scene.
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d{normal(random), normal(random), normal(random)}; };
  const auto quaternion = [&] {
    return Eigen::Quaterniond{normal(random), normal(random), normal(random), normal(random)}.normalized();
  };
  for (int round = 0; round < 500; ++round) {
    const Gaussian g{vector(), quaternion(), vector().cwiseAbs(), 0.5};
    const Similarity registration{std::exp(normal(random)), quaternion(), vector(), round % 2 == 1};
    SceneFilter filter;
    filter.sigma = std::exp(normal(random));
    const Ellipsoid scene = world_ellipsoid(g, filter, {});
    const Ellipsoid world = world_ellipsoid(g, filter, registration);
    ASSERT_LT((world.center - registration * g.position).norm(), 1e-12);
    const Eigen::Vector3d n = vector().normalized();
    ASSERT_NEAR(world.support(n),
                registration.scale * scene.support(registration.orthogonal().transpose() * n),
                1e-13 * world.radius());
    // and the covariance of eq. 2 is the Gaussian's: n^T Sigma n = |diag(sigma) R^T n|^2
    const double captured = (g.sigma.asDiagonal() * (g.rotation.conjugate() * n)).norm();
    ASSERT_NEAR(scene.support(n), filter.sigma * captured, 1e-13 * scene.radius());
  }
}

TEST(SceneFilter, ARegistrationThatOverflowsMakesADefect) {
  const GaussianScene scene = scene_of({{{1e5, 0, 0}}, {{1, 0, 0}}});
  FilterReport report;
  const EllipsoidScene kept =
      filter_scene(scene, {}, {1e9, Eigen::Quaterniond::Identity(), {0, 0, 0}}, report);
  EXPECT_EQ(kept.id, (Ids{1}));
  EXPECT_EQ(report.defects[static_cast<std::size_t>(Defect::kInfinite)], 1U);
  EXPECT_EQ(report.kept, 1U);
}

TEST(SceneFilter, AsksAboutOneGaussianAsAboutAScene) {
  const GaussianScene scene = mixed_scene(2000);
  FilterReport whole;
  const Ids kept = filter_scene(scene, strict_filter(), quarter_turn(0.9), whole).id;
  Ids ids;
  FilterReport first, second;  // of the two halves
  for (std::size_t i = 0; i < scene.size(); ++i) {
    FilterReport& half = i < 1000 ? first : second;
    if (keeps(scene, i, scene.gaussian(i), strict_filter(), quarter_turn(0.9), half))
      ids.push_back(scene.id[i]);
    EXPECT_EQ(half.total, i % 1000 + 1);
  }
  EXPECT_EQ(ids, kept);
  EXPECT_EQ(first += second, whole);
}

TEST(SceneFilter, TheReportsOfPartsAddUpInEveryMember) {
  const FilterReport a{1, {2, 3, 4, 5, 6}, 7, 8, 9, 10, 11};
  FilterReport sum{100, {200, 300, 400, 500, 600}, 700, 800, 900, 1000, 1100};
  sum += a;
  EXPECT_EQ(sum, (FilterReport{101, {202, 303, 404, 505, 606}, 707, 808, 909, 1010, 1111}));
}

TEST(SceneFilter, IsTheSameOnOneThreadAndOnSeveral) {
  const GaussianScene scene = mixed_scene(600'000);  // two rounds and a part of a third
  const auto filtered = [&](std::size_t threads, FilterReport& report) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return filter_scene(scene, strict_filter(), quarter_turn(0.9), report);
  };
  FilterReport one_report, four_report;
  const EllipsoidScene one = filtered(1, one_report);
  const EllipsoidScene four = filtered(4, four_report);
  EXPECT_EQ(one_report, four_report);
  EXPECT_EQ(one_report.total, scene.size());
  ASSERT_EQ(one.size(), one_report.kept);
  ASSERT_EQ(one.id, four.id);
  EXPECT_TRUE(std::is_sorted(one.id.begin(), one.id.end()));
  EXPECT_TRUE(one.opacity == four.opacity && one.color == four.color);
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one.ellipsoids[i].center, four.ellipsoids[i].center);
    ASSERT_EQ(one.ellipsoids[i].axes, four.ellipsoids[i].axes);
  }
}

TEST(SceneFilter, AFilterThatKeepsNothingLeavesEmptyArrays) {
  FilterReport report;
  SceneFilter filter;
  filter.opacity_min = 1.0;
  const EllipsoidScene kept = filter_scene(scene_of({{}, {}}), filter, {}, report);
  EXPECT_EQ(kept.size(), 0U);
  EXPECT_TRUE(kept.id.empty());
  EXPECT_TRUE(kept.opacity.empty());
  EXPECT_EQ(report.low_opacity, 2U);
  filter_scene(GaussianScene{}, filter, {}, report);
  EXPECT_EQ(report.total, 0U);
}

}  // namespace
}  // namespace palpate::test
