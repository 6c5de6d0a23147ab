// The lint report of scenes whose every figure is known by hand.

#include <gtest/gtest.h>

#include <palpate/scene/lint.h>

#include "support/not_finite.h"
#include "support/splats.h"

namespace palpate::test {
namespace {

/// 101 Gaussians at x = 0, 1, .. 100, alpha = k/255, longest sigma 0.01 k + 1, shortest 0.001 k + 0.1.
GaussianScene ladder() {
  std::vector<Splat> splats;
  for (int k = 0; k <= 100; ++k) splats.push_back({{1.0 * k, 0, 0}, {0.5, 1 + 0.01 * k, 0.1 + 0.001 * k}});
  GaussianScene scene = scene_of(splats);
  scene.opacity_encoding = OpacityEncoding::kByte;
  for (std::size_t k = 0; k <= 100; ++k) scene.opacity[k] = static_cast<float>(k);
  return scene;
}

TEST(Lint, QuantilesByHand) {
  const LintReport report = lint(ladder());
  const double ranks[] = {0, 1, 25, 50, 75, 99, 100};  // of 0, 0.01, 0.25, ... of 100
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) {
    EXPECT_DOUBLE_EQ(report.opacity[q], ranks[q] / 255);
    EXPECT_FLOAT_EQ(static_cast<float>(report.longest_sigma[q]), static_cast<float>(1 + 0.01 * ranks[q]));
    EXPECT_FLOAT_EQ(static_cast<float>(report.shortest_sigma[q]), static_cast<float>(0.1 + 0.001 * ranks[q]));
  }
}

TEST(Lint, BoundsByHand) {
  const LintReport report = lint(ladder());
  EXPECT_EQ(report.total, 101U);
  EXPECT_EQ(report.defects[0], 101U);
  EXPECT_EQ(report.bounds.min(), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(report.bounds.max(), Eigen::Vector3d(100, 0, 0));
  EXPECT_EQ(report.robust_bounds.min(), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(report.robust_bounds.max(), Eigen::Vector3d(99, 0, 0));
  EXPECT_EQ(report.robust_diagonal, 98.0);
  EXPECT_EQ(report.giant, 0U);
  EXPECT_EQ(report.flat, 0U);
}

TEST(Lint, AGiantSpansMoreThanATenthOfTheScene) {
  GaussianScene scene = ladder();
  scene.scale[3].x() = 9.75F;  // of 9.8
  EXPECT_EQ(lint(scene).giant, 0U);
  scene.scale[3].x() = 9.85F;
  EXPECT_EQ(lint(scene).giant, 1U);
  scene.scale[50].z() = 1e6F;
  EXPECT_EQ(lint(scene).giant, 2U);
}

TEST(Lint, AFloaterFarAwayDoesNotHideAGiant) {
  GaussianScene scene = ladder();
  scene.position[7].x() = 1e9F;  // one of 101: outside the central 98 %
  scene.scale[3].x() = 10.5F;
  EXPECT_EQ(lint(scene).giant, 1U);
  EXPECT_LT(lint(scene).robust_diagonal, 100.0);
}

TEST(Lint, CountsDiscsAndNeedlesAsFlat) {
  const LintReport report = lint(scene_of(
      {{{0, 0, 0}, {1, 1, 0}}, {{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {0, 0, 0}}}));
  EXPECT_EQ(report.flat, 2U);
  EXPECT_EQ(report.defects, (std::array<std::size_t, kDefectCount>{3, 0, 0, 0, 1}));
}

TEST(Lint, DefectsCountNowhereElse) {
  GaussianScene scene = ladder();
  scene.position[0].x() = kFloatNan;
  scene.position[1].x() = -1e30F;
  scene.rotation[2].setZero();
  scene.scale[3].setZero();
  scene.position[100].y() = kFloatInfinity;
  const LintReport report = lint(scene);
  EXPECT_EQ(report.total, 101U);
  EXPECT_EQ(report.defects, (std::array<std::size_t, kDefectCount>{96, 1, 2, 1, 1}));
  EXPECT_EQ(report.bounds.min().x(), 4.0);
  EXPECT_EQ(report.bounds.max().x(), 99.0);
  EXPECT_DOUBLE_EQ(report.opacity.front(), 4.0 / 255);
  EXPECT_DOUBLE_EQ(report.opacity.back(), 99.0 / 255);
  EXPECT_DOUBLE_EQ(report.share_above[0], 74.0 / 101);  // bytes 26 to 99; 25.5 is a tenth of 255
}

TEST(Lint, SharesCountWhatIsStrictlyAboveAThreshold) {
  const LintReport report = lint(ladder());             // opacities 0/255 to 100/255
  EXPECT_DOUBLE_EQ(report.share_above[0], 75.0 / 101);  // 26 to 100
  EXPECT_DOUBLE_EQ(report.share_above[1], 49.0 / 101);  // 52 to 100: 51/255 is 0.2 itself
  EXPECT_DOUBLE_EQ(report.share_above[2], 24.0 / 101);  // 77 to 100
}

TEST(Lint, NothingSoundIsNoError) {
  GaussianScene scene = scene_of({{}, {}});
  for (auto& q : scene.rotation) q.setZero();
  const LintReport report = lint(scene);
  EXPECT_TRUE(report.bounds.isEmpty());
  EXPECT_EQ(report.opacity, Quantiles{});
  EXPECT_EQ(report.robust_diagonal, 0.0);
  EXPECT_EQ(lint(GaussianScene{}).total, 0U);
}

TEST(Lint, OneGaussianIsNotAGiantInASceneOfNoSize) {
  const LintReport report = lint(scene_of({{}}));
  EXPECT_EQ(report.giant, 0U);
  EXPECT_EQ(report.bounds.min(), report.bounds.max());
  EXPECT_DOUBLE_EQ(report.opacity[3], scene_of({{}}).gaussian(0).opacity);
}

}  // namespace
}  // namespace palpate::test
