// How far there is a surface: where splats cover what the tool touches, in holes, at floaters, where light
// comes through.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/confidence.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool_query.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.02, kStiffness = 500.0, kSpacing = 0.004;

/// A sheet of flat splats in the plane z = 0 with `opacity`, without those that are nearer than `hole` to the
/// z axis.
std::vector<test::Splat> sheet(double opacity, double hole = 0.0) {
  std::vector<test::Splat> splats;
  for (int i = -25; i <= 25; ++i)
    for (int k = -25; k <= 25; ++k) {
      const Vector3d at(kSpacing * i, kSpacing * k, 0.0);
      if (at.norm() >= hole)
        splats.push_back(test::splat(at, {0.65 * kSpacing, 0.65 * kSpacing, 0.0002},
                                     Eigen::Quaterniond::Identity(), opacity));
    }
  return splats;
}

/// A ball that is lowered along the z axis until it is `depth` below the plane z = `top`.
ForceOutput press(const std::vector<test::Splat>& splats, double top, double depth,
                  ProxyParameters parameters = {}) {
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  parameters.stiffness = kStiffness;
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), parameters);
  ForceInput input;
  input.dt = 1e-3;
  ForceOutput felt;
  for (double z = top + kRadius + 0.02; z >= top + kRadius - depth - 1e-9; z -= 1e-4) {
    input.tool.position = {0, 0, z};
    input.velocity.linear = {0, 0, -0.1};
    felt = model.evaluate(input);
  }
  return felt;
}

TEST(Confidence, IsWholeOnASurface) {
  const ForceOutput felt = press(sheet(0.8), 0.0, 0.005);
  EXPECT_EQ(felt.confidence, 1.0);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * 0.005, 0.03 * kStiffness * 0.005);
}

TEST(Confidence, OfAFloaterIsSmallAndItDoesNotHideTheSurface) {
  auto splats = sheet(0.8);
  splats.push_back(test::splat({0, 0, 0.05}, {0.003, 0.003, 0.003}));  // alone, 50 mm above
  const ForceOutput floating = press(splats, 0.05, 0.005);             // seen in its middle
  EXPECT_NEAR(floating.confidence, 0.55, 0.1);
  EXPECT_NEAR(floating.wrench.force.norm(), 0.55 * kStiffness * 0.005, 0.2 * kStiffness * 0.005);
  const ForceOutput through = press(splats, 0.0, 0.005);
  EXPECT_NEAR(through.wrench.force.z(), kStiffness * 0.005, 0.05 * kStiffness * 0.005);
}

// A ball of 20 mm sinks into a hole of radius h by 20 - sqrt(20^2 - h^2), and rests on its rim, which splats
// make out to half of their distance.
TEST(SurfacePatches, ABallRestsOnTheRimOfAHole) {
  for (const double hole : {0.010, 0.015, 0.018}) {
    const double sag = kRadius - std::sqrt(kRadius * kRadius - hole * hole);
    for (const double deeper : {0.004, 0.008}) {
      const ForceOutput felt = press(sheet(0.8, hole), 0.0, sag + deeper);
      EXPECT_NEAR(felt.wrench.force.z(), kStiffness * deeper, 0.8) << hole << " " << deeper;
    }
  }
}

// Past the edge of half a sheet, which reaches a millimetre into the ball's flank, and back: it goes round
// the edge, and hangs on it in neither direction.
TEST(SurfacePatches, ABallSlipsPastAnEdge) {
  auto half = sheet(0.8);
  std::erase_if(half, [](const test::Splat& splat) { return splat.position.x() > 0.0; });
  const SceneIndex index(test::scene_of(half), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  const double edge = 0.65 * kSpacing;  // what is drawn goes on a little
  double most = 0.0;
  for (int tick = 0; tick <= 1600; ++tick) {
    const double z = tick <= 800 ? 0.04 - 1e-4 * tick : -0.12 + 1e-4 * tick;
    input.tool.position = {edge + kRadius - 0.001, 0.0003, z};
    most = std::max(most, model.evaluate(input).wrench.force.norm());
  }
  EXPECT_LT(most, kStiffness * 0.006);
}

// Paper eq. 9 with the opacity that is seen. 2 pi 0.65^2 = 2.65 splats lie over each other: of opacity 0.2
// they hide 1 - 0.8^2.65 = 0.446 in the mean, which is less than half; of 0.3 they hide 0.61, (0.61 - 0.5) /
// 0.4 of the way from half to what counts as opaque.
TEST(Confidence, FollowsTheOpacityThatIsSeen) {
  EXPECT_LT(press(sheet(0.2), 0.0, 0.005).wrench.force.z(), 0.1 * kStiffness * 0.005);
  const ForceOutput thin = press(sheet(0.3), 0.0, 0.005);
  EXPECT_NEAR(thin.confidence, 0.5 + 0.5 * 0.275, 0.1);
  EXPECT_NEAR(thin.wrench.force.z(), 0.6375 * kStiffness * 0.005, 0.2 * kStiffness * 0.005);
  EXPECT_EQ(press(sheet(0.99), 0.0, 0.005).confidence, 1.0);
}

TEST(Confidence, OfAContactIsThatOfItsPlace) {
  auto splats = sheet(0.8);
  splats.push_back(test::splat({0, 0, 0.05}, {0.003, 0.003, 0.003}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  const Tool tool({kRadius, kRadius, 0.030});  // touches both
  const Pose pose{{0, 0, 0.028}, Eigen::Quaterniond::Identity()};
  ContactSet set;
  query(index, tool, pose, set);
  const auto confidences = confidence(index, tool, pose, {}, set.contacts);
  ASSERT_EQ(confidences.size(), set.contacts.size());
  const auto floater = static_cast<std::uint32_t>(splats.size() - 1);
  bool seen = false;
  for (std::size_t i = 0; i < confidences.size(); ++i) {
    const bool floats = set.contacts[i].id == floater;
    seen = seen || floats;
    EXPECT_TRUE(floats ? confidences[i] < 0.7 : confidences[i] > 0.99) << confidences[i];
  }
  EXPECT_TRUE(seen);
}

// It is seen in its middle, as splatting draws it.
TEST(Confidence, IsNotLostWhereAllGaussiansAreLarge) {
  const std::vector<test::Splat> one{test::splat({0, 0, -0.1}, {0.1, 0.1, 0.1})};
  const ForceOutput felt = press(one, -0.1, 0.005);
  EXPECT_GT(felt.confidence, 0.9);
  EXPECT_GT(felt.wrench.force.z(), 0.8 * kStiffness * 0.005);
}

// Veils that let 0.7, 0.49 ... of the light through: the second one is felt, which nothing near it would
// hide.
TEST(Haze, IsFeltWhereItHasTakenHalfOfTheLight) {
  std::vector<test::Splat> veils;
  for (int k = 0; k < 4; ++k)
    veils.push_back(test::splat({0, 0, -0.015 * k}, {0.3, 0.3, 1e-5}, Eigen::Quaterniond::Identity(), 0.3));
  EXPECT_EQ(press(veils, 0.0, 0.005).wrench.force.z(), 0.0);
  EXPECT_EQ(press(veils, -0.015, -0.0002).wrench.force.z(), 0.0);
  // And it is there for as long as the ball is pressed in.
  for (const double depth : {0.002, 0.005, 0.015}) {
    const ForceOutput felt = press(veils, -0.015, depth);
    EXPECT_GE(felt.confidence, 0.5);
    EXPECT_NEAR(felt.wrench.force.z(), felt.confidence * kStiffness * depth, 0.1 * kStiffness * depth);
  }
}

std::shared_ptr<const MaterialMap> everywhere(const Material& material) {
  return std::make_shared<MaterialMap>(std::vector<MaterialRegion>{{MaterialRegion::Everywhere{}, material}});
}

TEST(ProxyMaterials, StiffnessIsThatOfWhatIsTouched) {
  ProxyParameters parameters;
  parameters.materials = everywhere({.stiffness = 1200.0});
  EXPECT_NEAR(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z(), 1200.0 * 0.005,
              0.03 * 1200.0 * 0.005);
}

TEST(ProxyMaterials, AreMixedWhereTheyMeet) {
  ProxyParameters parameters;
  const Eigen::AlignedBox3d half(Vector3d(-1, -1, -1), Vector3d(-1e-6, 1, 1));
  parameters.materials =
      std::make_shared<MaterialMap>(std::vector<MaterialRegion>{{half, {.stiffness = 1500.0}}});
  // The border runs under the ball: half of what it touches is 1500, half the usual 500.
  EXPECT_NEAR(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z(), 1000.0 * 0.005,
              0.15 * 1000.0 * 0.005);
}

TEST(ProxyMaterials, DampingAddsToThePushWhileTheToolGoesIn) {
  ProxyParameters parameters;
  parameters.materials = everywhere({.damping = 3.0});
  // At 0.1 m/s inwards, 3 N s/m.
  EXPECT_NEAR(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z(), kStiffness * 0.005 + 0.3,
              0.03 * kStiffness * 0.005);
}

}  // namespace
}  // namespace palpate
