// How far there is a surface: where splats cover what the tool touches, in holes, at floaters, where light
// comes through.

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/splat_tracker.h>
#include <palpate/geometry/solids.h>
#include <palpate/haptics/confidence.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/surface_patches.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/study/random.h>
#include <support/ball_on_surface.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::everywhere;
using test::kRadius;

constexpr double kUsualStiffness = 500.0, kSpacing = 0.004;

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
  parameters.stiffness = kUsualStiffness;
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
  EXPECT_NEAR(felt.wrench.force.z(), kUsualStiffness * 0.005, 0.03 * kUsualStiffness * 0.005);
}

TEST(Confidence, OfAFloaterIsSmallAndItDoesNotHideTheSurface) {
  auto splats = sheet(0.8);
  splats.push_back(test::splat({0, 0, 0.05}, {0.003, 0.003, 0.003}));  // alone, 50 mm above
  const ForceOutput floating = press(splats, 0.05, 0.005);             // seen in its middle
  EXPECT_NEAR(floating.confidence, 0.55, 0.1);
  EXPECT_NEAR(floating.wrench.force.norm(), 0.55 * kUsualStiffness * 0.005, 0.2 * kUsualStiffness * 0.005);
  const ForceOutput through = press(splats, 0.0, 0.005);
  EXPECT_NEAR(through.wrench.force.z(), kUsualStiffness * 0.005, 0.05 * kUsualStiffness * 0.005);
}

// A ball of 20 mm sinks into a hole of radius h by 20 - sqrt(20^2 - h^2), and rests on its rim, which splats
// make out to half of their distance.
TEST(SurfacePatches, ABallRestsOnTheRimOfAHole) {
  for (const double hole : {0.010, 0.015, 0.018}) {
    const double sag = kRadius - std::sqrt(kRadius * kRadius - hole * hole);
    for (const double deeper : {0.004, 0.008}) {
      const ForceOutput felt = press(sheet(0.8, hole), 0.0, sag + deeper);
      EXPECT_NEAR(felt.wrench.force.z(), kUsualStiffness * deeper, 0.8) << hole << " " << deeper;
    }
  }
}

// And sinks in if it comes along the sheet, though not all at once.
TEST(SurfacePatches, ABallSlidesIntoAHole) {
  constexpr double kHole = 0.015, kDeeper = 0.004;
  const SceneIndex index(test::scene_of(sheet(0.8, kHole)), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
  const double sag = kRadius - std::sqrt(kRadius * kRadius - kHole * kHole);
  ForceInput input;
  input.dt = 1e-3;
  ForceOutput felt;
  const double below = kRadius - sag - kDeeper;
  input.tool.position = {-0.06, 0.0, kRadius + 0.01};
  for (; input.tool.position.z() > below; input.tool.position.z() -= 1e-4) felt = model.evaluate(input);
  EXPECT_NEAR(felt.wrench.force.z(), kUsualStiffness * (sag + kDeeper), 0.2);
  for (; input.tool.position.x() < 0.0; input.tool.position.x() += 1e-4) felt = model.evaluate(input);
  EXPECT_GT(felt.wrench.force.z(), kUsualStiffness * kDeeper - 0.2);
  EXPECT_LT(felt.wrench.force.z(), kUsualStiffness * (0.5 * sag + kDeeper));
}

/// A wire along y through the origin.
std::vector<test::Splat> wire() {
  std::vector<test::Splat> splats;
  for (int k = -50; k <= 50; ++k)
    splats.push_back(
        test::splat({0, 0.001 * k, 0}, {3e-4, 0.001, 3e-4}, Eigen::Quaterniond::Identity(), 0.95));
  return splats;
}

// Met by its flank, a tool is pushed away from the wire as it faces there, not straight up: the gradient of
// the ellipsoid.
TEST(SurfacePatches, AThinThingPushesAsTheToolFacesIt) {
  const SceneIndex index(test::scene_of(wire()), SceneFilter{}, Similarity{});
  for (const Vector3d& semi_axes : {Vector3d(0.02, 0.02, 0.02), Vector3d(0.03, 0.02, 0.015)}) {
    ProxyForce model(index, Tool(semi_axes), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    ForceOutput felt;
    input.tool.position = {0.5 * semi_axes.x(), 0.0, 0.03};
    const double meets = std::sqrt(0.75) * semi_axes.z();
    for (; input.tool.position.z() > meets - 0.003; input.tool.position.z() -= 1e-4)
      felt = model.evaluate(input);
    const Ellipsoid proxy = Tool(semi_axes).parts()[0].at(felt.proxy);
    const Eigen::Matrix3d inverse = proxy.axes.inverse();
    const Vector3d inwards = (inverse.transpose() * inverse * proxy.center).normalized();
    const Vector3d force = felt.wrench.force.normalized();
    EXPECT_GT(felt.wrench.force.norm(), 0.3);
    EXPECT_GT(force.dot(inwards), std::cos(0.15)) << force.transpose() << " " << inwards.transpose();
  }
}

// Either is where the other mirrors it, and no other: one alone would let the rod tip over. In the very
// middle, too, where both are lost from sight at once.
TEST(SurfacePatches, ARodLiesOnTwoSupports) {
  const Vector3d rod(0.1, 0.02, 0.02);
  std::vector<test::Splat> supports;
  for (const double x : {-0.06, 0.06})
    for (int i = -5; i <= 5; ++i)
      for (int k = -5; k <= 5; ++k)
        supports.push_back(test::splat({x + 0.002 * i, 0.002 * k, 0.0}, {0.0015, 0.0015, 0.0002}));
  const SceneIndex index(test::scene_of(supports), SceneFilter{}, Similarity{});
  for (const double aside : {0.0, 1e-5, 2e-4}) {
    ProxyForce model(index, Tool(rod), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    ForceOutput felt;
    for (double z = 0.04; z > 0.011; z -= 1e-4) {
      input.tool.position = {aside, aside, z};
      felt = model.evaluate(input);
    }
    EXPECT_GT(felt.wrench.force.z(), 1.0) << aside;
    EXPECT_LT(felt.wrench.torque.norm(), 0.25 * 0.06 * felt.wrench.force.z()) << aside;
    EXPECT_LT(std::abs(felt.proxy.orientation.y()), 0.01) << aside;
  }
}

// As patches, wherever in the world they are.
TEST(SurfacePatches, TwoSupportsAreTwoPatches) {
  for (const Vector3d& at : {Vector3d(0, 0, 0), Vector3d(1, -2, 0.5), Vector3d(0.06, 0, 0)}) {
    std::vector<test::Splat> supports;
    for (const double x : {-0.06, 0.06})
      for (int i = -5; i <= 5; ++i)
        for (int k = -5; k <= 5; ++k) {
          if (x > 0.0 && (i + k) % 2 != 0) continue;  // so that they are not made of as many
          supports.push_back(
              test::splat(at + Vector3d(x + 0.002 * i, 0.002 * k, 0.0), {0.002, 0.002, 0.0002}));
        }
    const SceneIndex index(test::scene_of(supports), SceneFilter{}, Similarity{});
    const Vector3d rod(0.1, 0.02, 0.02), above = at + Vector3d(0.0002, 0.0007, 0.0165);
    const Ellipsoid solid = Ellipsoid::from_semi_axes({above, Eigen::Quaterniond::Identity()}, rod);
    SplatTracker tracker(index);
    WorkBudget budget;
    SurfacePatches patches(0.01, (rod.array() + 0.01) / rod.array(), budget);
    const LocalSplats& splats = tracker.around(enlarged(solid, 0.01));
    patches.view_ahead(splats, solid, -Vector3d::UnitZ(), above - 0.02 * Vector3d::UnitZ(), 0.002, 0.0,
                       [] { return true; });
    ASSERT_EQ(patches.patches().size(), 2U);
    EXPECT_LT((patches.patches()[0].foot - above).x() * (patches.patches()[1].foot - above).x(), 0.0);
    // Each is made of what is on its own side, where the solid has moved and where it has not.
    for (const double lower : {0.001, 0.001, 0.0012}) {
      patches.follow(splats, {above - lower * Vector3d::UnitZ(), solid.axes});
      ASSERT_EQ(patches.patches().size(), 2U);
      for (std::size_t k = 0; k < 2; ++k) {
        const double side = (patches.patches()[k].foot - above).x();
        double sum = 0.0;
        for (const PatchWitness& witness : patches.witnesses(k)) {
          sum += witness.weight;
          EXPECT_GT(side * (witness.position - above).x(), 0.0);
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
      }
    }
  }
}

/// Patches of `detail` that a solid with these semi-axes has on a scene.
struct Feeler {
  Feeler(const std::vector<test::Splat>& splats, const Vector3d& semi_axes, double detail)
      : axes(semi_axes),
        index(test::scene_of(splats), SceneFilter{}, Similarity{}),
        tracker(index),
        patches(detail, (axes.array() + kMore) / axes.array(), budget) {}

  Ellipsoid solid(const Vector3d& at) const {
    return Ellipsoid::from_semi_axes({at, Eigen::Quaterniond::Identity()}, axes);
  }
  const LocalSplats& around(const Vector3d& at) { return tracker.around(enlarged(solid(at), kMore)); }
  void follow(const Vector3d& at) { patches.follow(around(at), solid(at)); }
  std::optional<double> look_down(const Vector3d& at, double way) {
    const Vector3d down = -Vector3d::UnitZ();
    return patches.view_ahead(around(at), solid(at), down, at + axes.z() * down, way, 0.0,
                              [] { return true; });
  }

  static constexpr double kMore = 0.02;
  Vector3d axes;
  SceneIndex index;
  SplatTracker tracker;
  WorkBudget budget;
  SurfacePatches patches;
};

// The material of a patch is known until it is fitted to another view.
TEST(SurfacePatches, KnowTheirMaterialForAsLongAsTheirWitnessesAreTheSame) {
  Feeler ball(sheet(0.8), Vector3d::Constant(kRadius), 0.013);
  Vector3d at(0.001, 0.001, kRadius + 0.0005);
  ball.look_down(at, 0.002);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  EXPECT_FALSE(ball.patches.patches()[0].material);
  ball.patches.set_material(0, {1200.0, 0.3, 2.0});
  ball.follow(at);
  at.x() += 1e-5;  // less than needs another view
  ball.follow(at);
  ball.patches.carry(ball.solid(at));
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  ASSERT_TRUE(ball.patches.patches()[0].material);
  EXPECT_EQ(ball.patches.patches()[0].material->stiffness, 1200.0);
  at.x() += 1e-3;
  ball.follow(at);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  EXPECT_FALSE(ball.patches.patches()[0].material);
}

// On a plane that all of a long solid is above, one patch answers for all of it.
TEST(SurfacePatches, OnePlaneIsOnePatch) {
  Feeler rod(sheet(0.8), {0.08, 0.02, 0.02}, 0.01);
  rod.look_down({0.001, 0.001, 0.0205}, 0.002);
  EXPECT_EQ(rod.patches.patches().size(), 1U);
}

// Of a slope that a rod touches far from its middle, what is nearest to the foot counts most.
TEST(SurfacePatches, WitnessesCountByTheirDistanceFromTheFoot) {
  const Eigen::Quaterniond slope(Eigen::AngleAxisd(0.35, Vector3d::UnitY()));
  std::vector<test::Splat> splats;
  for (int i = -50; i <= 50; ++i)
    for (int k = -20; k <= 20; ++k)
      splats.push_back(
          test::splat(slope * Vector3d(0.002 * i, 0.002 * k, 0.0), {0.0016, 0.0016, 1e-5}, slope));
  const Vector3d up = slope * Vector3d::UnitZ(), axes(0.08, 0.02, 0.02);
  Feeler rod(splats, axes, 0.01);
  const Vector3d at = (axes.cwiseProduct(up).norm() + 0.0005) * up;
  rod.look_down(at, 0.002);
  ASSERT_EQ(rod.patches.patches().size(), 1U);
  const SurfacePatch& patch = rod.patches.patches()[0];
  ASSERT_GT((patch.foot - at).cross(up).norm(), 0.03);
  const auto witnesses = rod.patches.witnesses(0);
  ASSERT_GT(witnesses.size(), 30U);
  const PatchWitness heaviest = std::ranges::max(witnesses, {}, &PatchWitness::weight);
  EXPECT_LT((heaviest.position - patch.foot).cross(up).norm(), 0.003);
}

// What a patch is mostly made of: of a wide Gaussian beside small ones, that where it is most of what is
// seen.
TEST(SurfacePatches, KnowWhatTheyAreMostlyMadeOf) {
  std::vector<test::Splat> splats;
  for (int i = 0; i <= 30; ++i)
    for (int k = -30; k <= 30; ++k)
      splats.push_back(test::splat({0.012 + 0.001 * i, 0.001 * k, 0.0}, {8e-4, 8e-4, 1e-5}));
  const auto wide = static_cast<std::uint32_t>(splats.size());
  splats.push_back(
      test::splat({-0.018, 0.0, 0.0}, {0.015, 0.015, 1e-5}, Eigen::Quaterniond::Identity(), 0.99));
  const auto mostly_at = [&](double x) {
    Feeler ball(splats, Vector3d::Constant(kRadius), 0.008);
    ball.look_down({x, 0.0, kRadius + 0.0005}, 0.002);
    EXPECT_EQ(ball.patches.patches().size(), 1U);
    return ball.patches.patches()[0].mostly;
  };
  EXPECT_EQ(mostly_at(-0.015), wide);
  EXPECT_EQ(mostly_at(0.030), std::nullopt);
  // Between them, it is what has more than half of the weight.
  int mixed = 0;
  for (double x = -0.01; x < 0.02; x += 0.0005) {
    Feeler ball(splats, Vector3d::Constant(kRadius), 0.008);
    ball.look_down({x, 0.0, kRadius + 0.0005}, 0.002);
    ASSERT_EQ(ball.patches.patches().size(), 1U);
    double share = 0.0;
    for (const PatchWitness& witness : ball.patches.witnesses(0))
      share += witness.id == wide ? witness.weight : 0.0;
    mixed += share > 0.5 && share < 0.9 ? 1 : 0;
    EXPECT_EQ(ball.patches.patches()[0].mostly, share > 0.5 ? std::optional(wide) : std::nullopt) << x;
  }
  EXPECT_GT(mixed, 3);
}

// Half a detail, 5 mm, above a plane that it has touched, a solid has a patch yet; it sees the plane ahead
// again where it is farther away than it wants to go, and above that it has none.
TEST(SurfacePatches, ArePatchesToHalfADetailAboveThem) {
  Feeler ball(sheet(0.8), Vector3d::Constant(kRadius), 0.01);
  ball.look_down({0.001, 0.001, kRadius + 0.0005}, 0.002);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  const Vector3d lifted(0.001, 0.001, kRadius + 0.004);
  ball.follow(lifted);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  EXPECT_NEAR(ball.patches.patches()[0].gap, 0.004, 3e-4);
  const std::optional<double> clear = ball.look_down(lifted, 0.001);
  ASSERT_TRUE(clear);
  EXPECT_NEAR(*clear, 0.004, 3e-4);
  ball.follow({0.001, 0.001, kRadius + 0.006});
  EXPECT_EQ(ball.patches.patches().size(), 0U);
}

// A tip that is under the surface by less than a detail, and so deep that its rays would begin beyond it,
// sees it all the same; one that is deeper does not, and what it knows stays where it was.
TEST(SurfacePatches, AreSeenByATipThatIsLittleBelowThem) {
  constexpr double kTip = 0.002, kDetail = 0.004;
  Feeler tip({test::splat({0, 0, 0}, {0.5, 0.5, 1e-6})}, Vector3d::Constant(kTip), kDetail);
  tip.look_down({0, 0, kTip + 0.0005}, 0.002);
  for (double depth = 0.0002; depth < 1.5 * kDetail; depth += 0.0003) {
    const Vector3d at(0, 0, kTip - depth);
    tip.follow(at);
    ASSERT_EQ(tip.patches.patches().size(), 1U) << depth;
    const SurfacePatch& patch = tip.patches.patches()[0];
    EXPECT_NEAR(patch.gap, -depth, 1e-5);
    EXPECT_EQ(patch.seen_by.center == at, depth < kDetail + 0.0003) << depth;  // by where it was before
  }
}

// From a floor onto one that is rough: the felt surface goes from the fit to what is nearest to the tool by
// and by. Every 8 mm, the rough one looks the same.
TEST(SurfacePatches, TheOffsetGoesToWhatIsNearest) {
  constexpr double kDetail = 0.01, kStep = 0.0005, kPeriod = 0.008, kAbove = 0.001;
  const auto floor = [](double step) {
    std::vector<test::Splat> splats;
    for (int i = -35; i <= 110; ++i)
      for (int k = -35; k <= 35; ++k) {
        const double x = 0.001 * i + 1e-5, y = 0.001 * k + 1e-5;
        const bool high = (std::sin(2.0 * std::numbers::pi * x / kPeriod) > 0.0) ==
                          (std::sin(2.0 * std::numbers::pi * y / kPeriod) > 0.0);
        splats.push_back(test::splat({x, y, high ? step : -step}, {8e-4, 8e-4, 1e-6},
                                     Eigen::Quaterniond::Identity(), 0.95));
      }
    return splats;
  };
  const std::vector<test::Splat> even = floor(0.0), rough = floor(kStep);
  // In the middle of what is high.
  const auto at = [](int periods) { return Vector3d(periods * kPeriod + 0.002, 0.002, kRadius + kAbove); };
  Feeler ball(even, Vector3d::Constant(kRadius), kDetail), later(rough, ball.axes, kDetail);
  ball.look_down(at(0), 0.002);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  const SurfacePatch& patch = ball.patches.patches()[0];
  EXPECT_NEAR(patch.offset, 0.0, 5e-5);
  std::vector<double> offsets;
  for (int periods = 1; periods <= 10; ++periods) {
    ball.budget.refill();
    ball.patches.follow(later.around(at(periods)), ball.solid(at(periods)));
    ASSERT_EQ(ball.patches.patches().size(), 1U) << periods;
    EXPECT_LE(std::abs(patch.offset), 3.0 * kStep) << periods;
    offsets.push_back(patch.offset);
  }
  EXPECT_LT(offsets.front(), -0.05 * kStep) << "a first part of the way to what is nearest";
  const double whole = std::accumulate(offsets.end() - 5, offsets.end(), 0.0) / 5.0;
  EXPECT_LT(whole, 1.2 * offsets.front()) << "and no more than that";
}

// Over a globe, from its pole to its equator: where the rays are counted from stays under the solid and on
// the surface, and what a patch remembers is of the last look.
TEST(SurfacePatches, RememberTheLastLook) {
  constexpr double kGlobe = 0.1, kDetail = 0.008, kAbove = 0.0005;
  std::vector<test::Splat> globe;
  constexpr int kCount = 20000;
  for (int k = 0; k < kCount; ++k) {
    const double z = 1.0 - 2.0 * (k + 0.5) / kCount, angle = 2.39996 * k, s = std::sqrt(1.0 - z * z);
    const Vector3d n(s * std::cos(angle), s * std::sin(angle), z);
    globe.push_back(test::splat(kGlobe * n, {0.0018, 0.0018, 1e-5},
                                Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n)));
  }
  Feeler ball(globe, Vector3d::Constant(kRadius), kDetail);
  const auto at = [&](double angle) {
    return Vector3d((kGlobe + kRadius + kAbove) * Vector3d(std::sin(angle), 0.0, std::cos(angle)));
  };
  ball.look_down(at(0.0), 0.002);
  for (double angle = 0.0; angle < 0.5 * std::numbers::pi; angle += 0.005) {
    ball.budget.refill();
    ball.follow(at(angle));
    ASSERT_EQ(ball.patches.patches().size(), 1U) << angle;
    const SurfacePatch& patch = ball.patches.patches()[0];
    const Vector3d under = at(angle).normalized();
    EXPECT_GT(patch.normal.dot(under), std::cos(0.02)) << angle;
    EXPECT_NEAR(patch.gap, kAbove, 2e-4) << angle;
    EXPECT_NEAR(patch.anchor.norm(), kGlobe, 0.002) << angle;
    EXPECT_LT((patch.anchor - kGlobe * under).norm(), 0.3 * SurfacePatches::kWindow * kDetail) << angle;
    EXPECT_NEAR(patch.sight.norm(), kGlobe, 1e-3) << angle;
    EXPECT_LT((patch.sight - kGlobe * under).norm(), 0.5 * SurfacePatches::kWindow * kDetail) << angle;
    if (patch.viewed_from.center != at(angle)) continue;
    EXPECT_EQ(patch.seen_by.center, at(angle));
    EXPECT_NEAR((patch.seen_at - patch.foot).norm(), 0.0, 1e-12) << angle;
    EXPECT_NEAR((patch.foot - (at(angle) - kRadius * patch.normal)).norm(), 0.0, 2e-4) << angle;
  }
}

// In a hollow that is smaller than the ball, it touches on all sides: no more patches than there is room for,
// and none once nothing may be looked at.
TEST(SurfacePatches, AreNoMoreThanThereIsRoomFor) {
  std::vector<test::Splat> hollow;
  constexpr int kCount = 2000;
  for (int k = 0; k < kCount; ++k) {
    const double z = 1.0 - 2.0 * (k + 0.5) / kCount, angle = 2.39996 * k, s = std::sqrt(1.0 - z * z);
    const Vector3d n(s * std::cos(angle), s * std::sin(angle), z);
    hollow.push_back(test::splat(0.95 * kRadius * n, {0.001, 0.001, 1e-5},
                                 Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n)));
  }
  const SceneIndex index(test::scene_of(hollow), SceneFilter{}, Similarity{});
  const Ellipsoid solid = Ellipsoid::from_semi_axes({}, Vector3d::Constant(kRadius));
  SplatTracker tracker(index);
  const LocalSplats& splats = tracker.around(enlarged(solid, 0.005));
  WorkBudget budget;
  SurfacePatches patches(0.003, Vector3d::Constant((kRadius + 0.005) / kRadius), budget);
  for (const test::Splat& splat : hollow) {
    budget.refill();
    patches.add_at(splats, solid, -splat.position.normalized(), splat.position);
    ASSERT_LE(patches.patches().size(), SurfacePatches::kMost);
  }
  EXPECT_EQ(patches.patches().size(), SurfacePatches::kMost);
  patches.clear();
  while (!budget.is_spent()) budget.spend_on_view(splats.size, splats.size, splats.size);
  EXPECT_FALSE(patches.add_at(splats, solid, Vector3d::UnitZ(), -0.95 * kRadius * Vector3d::UnitZ()));
}

/// An eight-sided pipe along x that a ball of radius `radius` fits in, with an end across x = 0.
std::vector<test::Splat> closed_pipe(double radius) {
  constexpr double kApart = 0.002;
  constexpr int kSides = 8, kAcross = 12, kLength = 60;
  std::vector<test::Splat> splats;
  const auto add = [&](const Vector3d& at, const Vector3d& normal) {
    splats.push_back(test::splat(at, {0.0015, 0.0015, 1e-4},
                                 Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal)));
  };
  for (int k = -kAcross; k <= kAcross; ++k)
    for (int i = -kAcross; i <= kAcross; ++i) add({0.0, kApart * i, kApart * k}, Vector3d::UnitX());
  const double half = std::tan(std::numbers::pi / kSides) * radius;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2.0 * std::numbers::pi * side / kSides;
    const Vector3d normal(0.0, std::cos(angle), std::sin(angle)), across = normal.cross(Vector3d::UnitX());
    for (int k = -kAcross; k <= kAcross; ++k)
      for (int i = 0; i < kLength && std::abs(kApart * k) <= half; ++i)
        add(radius * normal + kApart * k * across - kApart * i * Vector3d::UnitX(), normal);
  }
  return splats;
}

// A ball that a pipe holds all around has as many patches as there is room for. It meets the end of the pipe
// all the same, on the axis and pressed against a wall.
TEST(SurfacePatches, AWallIsMetWhereThereIsNoRoomForItsPatch) {
  constexpr double kAside = 0.004, kPast = 0.03, kFrom = -0.05;
  for (const double pipe : {0.0202, 0.0203, 0.0205}) {
    const SceneIndex index(test::scene_of(closed_pipe(pipe)), SceneFilter{}, Similarity{});
    for (const double pressed : {0.0, kAside}) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)),
                       {.stiffness = kUsualStiffness, .detail = 0.004});
      ForceInput input;
      input.dt = 1e-3;
      ForceOutput felt;
      const auto at = [&](double x, double aside, double angle) {
        input.tool.position = {x, aside * std::cos(angle), aside * std::sin(angle)};
        felt = model.evaluate(input);
      };
      for (int k = 0; k < 50; ++k) at(kFrom, 0.0, 0.0);
      for (double angle = 0.0; angle < 2.0 * std::numbers::pi; angle += 0.3) at(kFrom, kAside, angle);
      double farthest = kFrom;
      for (double x = kFrom; x < -kRadius + kPast; x += 1e-4) {
        at(x, pressed, 0.0);
        farthest = std::max(farthest, felt.proxy.position.x());
      }
      EXPECT_NEAR(farthest, -kRadius, 5e-4) << pipe << " " << pressed;
      EXPECT_NEAR(felt.wrench.force.x(), -kUsualStiffness * kPast, 0.15 * kUsualStiffness * kPast)
          << pipe << " " << pressed;
    }
  }
}

// What makes room for it is what is farthest away by then, and what is nearer than the new one stays.
TEST(SurfacePatches, WhatIsFarthestAwayMakesRoom) {
  constexpr double kPipe = 0.0205, kOff = 3e-4, kClear = 5e-4;
  Feeler ball(closed_pipe(kPipe), Vector3d::Constant(kRadius), 0.013);
  const Vector3d at(-kRadius - kClear, kOff, 0.0);
  const auto look = [&](const Vector3d& along) {
    ball.budget.refill();
    ball.patches.view_ahead(ball.around(at), ball.solid(at), along, at + kRadius * along, 0.002, 0.0,
                            [] { return true; });
  };
  for (int k = 0; k < 8; ++k) {
    const double angle = 0.25 * std::numbers::pi * k;
    look({0.0, std::cos(angle), std::sin(angle)});
  }
  ASSERT_EQ(ball.patches.patches().size(), SurfacePatches::kMost);
  ASSERT_EQ(ball.patches.added(), SurfacePatches::kMost);
  look(Vector3d::UnitX());
  ASSERT_EQ(ball.patches.patches().size(), SurfacePatches::kMost);
  EXPECT_EQ(ball.patches.added(), SurfacePatches::kMost + 1);
  int ends = 0;
  for (const SurfacePatch& patch : ball.patches.patches()) {
    EXPECT_LT(patch.normal.y(), 0.9) << "the wall that is 0.8 mm away";
    ends += patch.normal.x() < -0.9 ? 1 : 0;
  }
  EXPECT_EQ(ends, 1);
}

// Otherwise a view that takes more than a tick would find the same again in the next, and never end.
TEST(SurfacePatches, WhatAViewAheadHasAddedStaysUntilTheSolidMoves) {
  Feeler ball(sheet(0.95), Vector3d::Constant(kRadius), 0.01);
  const Vector3d at(0.001, 0.001, kRadius + 0.008);  // farther away than patches that are kept on a motion
  ball.look_down(at, 0.01);
  ASSERT_EQ(ball.patches.patches().size(), 1U);
  for (int tick = 0; tick < 3; ++tick) ball.follow(at);
  EXPECT_EQ(ball.patches.patches().size(), 1U);
  ball.follow(at + 1e-4 * Vector3d::UnitZ());
  EXPECT_EQ(ball.patches.patches().size(), 0U);
}

// So small that no ray of the lattice need meet it: it is felt from where it is met, however quickly.
TEST(SurfacePatches, ASpeckIsFeltWhereItIs) {
  const SceneIndex index(test::scene_of({test::splat({0.003, 0.002, 0}, {1e-4, 1e-4, 1e-4},
                                                     Eigen::Quaterniond::Identity(), 0.95)}),
                         SceneFilter{}, Similarity{});
  // Of a ball, the point above (3, 2) mm.
  const double meets = std::sqrt(kRadius * kRadius - 1.3e-5);
  for (const double step : {1e-4, 1e-3}) {
    ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    ForceOutput felt;
    for (int tick = 0; tick <= static_cast<int>(0.025 / step + 0.5); ++tick) {
      input.tool.position = {0, 0, meets + 0.02 - step * tick};
      felt = model.evaluate(input);
    }
    EXPECT_NEAR(felt.wrench.force.z(), felt.confidence * kUsualStiffness * 0.005,
                0.1 * kUsualStiffness * 0.005)
        << step;
  }
}

// A speck has the usual material, and not that of what was touched before.
TEST(SurfacePatches, ASpeckHasTheUsualMaterial) {
  constexpr double kFloor = -0.1, kDepth = 0.004;
  std::vector<test::Splat> splats;
  for (int i = -10; i <= 10; ++i)
    for (int k = -10; k <= 10; ++k)
      splats.push_back(test::splat({kFloor + kSpacing * i, kSpacing * k, 0.0},
                                   {0.65 * kSpacing, 0.65 * kSpacing, 0.0002}));
  splats.push_back(test::splat({0.003, 0.002, 0}, {1e-4, 1e-4, 1e-4}, Eigen::Quaterniond::Identity(), 0.95));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  const Eigen::AlignedBox3d floor(Vector3d(-1, -1, -1), Vector3d(-0.04, 1, 1));
  ProxyParameters parameters{.stiffness = kUsualStiffness};
  parameters.materials =
      std::make_shared<MaterialMap>(std::vector<MaterialRegion>{{floor, {.stiffness = 3000.0}}});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), parameters);
  ForceInput input;
  input.dt = 1e-3;
  ForceOutput felt;
  const auto press_at = [&](double x, double touches) {
    for (int k = -100; k <= 40; ++k) {
      input.tool.position = {x, 0.0, touches - 1e-4 * k};
      felt = model.evaluate(input);
    }
    const ForceOutput deepest = felt;
    for (int k = 40; k >= -100; --k) {
      input.tool.position = {x, 0.0, touches - 1e-4 * k};
      felt = model.evaluate(input);
    }
    return deepest;
  };
  EXPECT_NEAR(press_at(kFloor, kRadius).wrench.force.z(), 3000.0 * kDepth, 0.05 * 3000.0 * kDepth);
  for (double x = kFloor; x < 0.0; x += 1e-3) {
    input.tool.position.x() = x;
    model.evaluate(input);
  }
  const ForceOutput speck = press_at(0.0, std::sqrt(kRadius * kRadius - 1.3e-5));
  EXPECT_NEAR(speck.wrench.force.z(), speck.confidence * kUsualStiffness * kDepth,
              0.15 * kUsualStiffness * kDepth);
}

// A lone Gaussian, larger than the tool and thick: from the side it is seen in another plane through its
// middle, which is no wall before a ball that it holds.
TEST(SurfacePatches, AGaussianIsNoWallBeforeAToolThatItHolds) {
  constexpr double kBall = 0.01, kDepth = 0.005, kStep = 1e-4;
  const std::vector<test::Splat> splats{
      test::splat({0, 0, 0}, {0.038, 0.078, 0.019}, Eigen::Quaterniond::Identity(), 0.99)};
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  for (int k = 0; k < 12; ++k) {
    const double angle = k * std::numbers::pi / 6.0;
    const Vector3d way(0.028 * std::cos(angle), 0.05 * std::sin(angle), 0.0);
    ProxyForce model(index, Tool(Vector3d::Constant(kBall)), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    // It is seen in the plane through its middle from above, too.
    for (double z = 0.05; z > kBall - kDepth; z -= kStep) {
      input.tool.position = -way + z * Vector3d::UnitZ();
      model.evaluate(input);
    }
    for (double share = -1.0; share < 1.0; share += kStep / way.norm()) {
      input.tool.position = share * way + (kBall - kDepth) * Vector3d::UnitZ();
      const Vector3d force = model.evaluate(input).wrench.force;
      ASSERT_NEAR(force.z(), kUsualStiffness * kDepth, 0.3 * kUsualStiffness * kDepth)
          << k << " at " << share;
      ASSERT_LT(force.head<2>().norm(), 0.3 * kUsualStiffness * kDepth) << k << " at " << share;
    }
  }
}

// What is beside a ball, above its middle, is not what it stands on.
TEST(SurfacePatches, AShelfBesideTheToolIsNotFelt) {
  const auto floor = sheet(0.8);
  auto shelved = floor;
  for (const test::Splat& splat : floor)
    if (splat.position.x() > 0.024)
      shelved.push_back(test::splat(splat.position + Vector3d(0, 0, 1.5 * kRadius), splat.sigma,
                                    Eigen::Quaterniond::Identity(), 0.8));
  const Vector3d below = press(shelved, 0.0, 0.005).wrench.force;
  EXPECT_NEAR((below - press(floor, 0.0, 0.005).wrench.force).norm(), 0.0, 2e-4);
}

// What is slid into is a wall if it is opaque and as wide as the tool: haze is none, nor is a bar.
TEST(SurfacePatches, OnlyACertainWallIsSlidInto) {
  const auto walls = [](const std::vector<test::Splat>& splats) {
    Feeler ball(splats, Vector3d::Constant(kRadius), 0.008);
    const Vector3d at(0.001, 0.001, kRadius + 0.0005), down = -Vector3d::UnitZ();
    ball.patches.view_ahead(ball.around(at), ball.solid(at), down, at + kRadius * down, 0.002, 0.98,
                            [] { return true; });
    return ball.patches.patches().size();
  };
  std::vector<test::Splat> bar = sheet(0.95);
  std::erase_if(bar, [](const test::Splat& splat) { return std::abs(splat.position.y()) > 0.001; });
  EXPECT_EQ(walls(sheet(0.95)), 1U);
  EXPECT_EQ(walls(bar), 0U);
  EXPECT_EQ(walls({test::splat({0, 0, 0}, {0.5, 0.5, 1e-6}, Eigen::Quaterniond::Identity(), 0.6)}), 0U);
}

// Off the end of a sheet, 10 mm deep: the force goes, but no faster than the tool moves and a little, and it
// does not wait for the tool to move.
TEST(SurfacePatches, TheForceIsLetGoSlowlyWhereTheGroundEnds) {
  auto half = sheet(0.8);
  std::erase_if(half, [](const test::Splat& splat) { return splat.position.x() > 0.0; });
  const SceneIndex index(test::scene_of(half), SceneFilter{}, Similarity{});
  for (const double step : {1e-4, 1e-3}) {
    constexpr double kDepth = 0.010, kALittle = 2e-4;
    ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    Vector3d last = Vector3d::Zero();
    for (double z = 0.03; z > kRadius - kDepth; z -= step) {
      input.tool.position = {-0.05, 0.0003, z};
      last = model.evaluate(input).wrench.force;
    }
    EXPECT_NEAR(last.z(), kUsualStiffness * kDepth, 0.12 * kUsualStiffness * kDepth);
    double most = 0.0;
    const auto feel = [&] {
      const Vector3d force = model.evaluate(input).wrench.force;
      most = std::max(most, (force - last).norm());
      last = force;
    };
    for (; input.tool.position.x() < 0.022; input.tool.position.x() += step) feel();
    EXPECT_LE(most, kUsualStiffness * (2.0 * step + kALittle)) << step;
    for (int tick = 0; tick < 500; ++tick) feel();
    EXPECT_LE(most, kUsualStiffness * (2.0 * step + kALittle)) << step;
    EXPECT_EQ(last, Vector3d(0, 0, 0)) << step;
  }
}

// Where nothing is seen any more, a patch stays where it was for half a detail, and no longer.
TEST(SurfacePatches, AreForgottenBesideWhereTheyWere) {
  constexpr double kDetail = 0.01;
  for (const double aside : {0.004, 0.006}) {
    Feeler ball(sheet(0.8), Vector3d::Constant(kRadius), kDetail);
    ball.look_down({0.001, 0.001, kRadius + 0.0005}, 0.002);
    ASSERT_EQ(ball.patches.patches().size(), 1U);
    const LocalSplats nothing;
    ball.patches.follow(nothing, ball.solid({0.001 + aside, 0.001, kRadius - 0.003}));
    EXPECT_EQ(ball.patches.patches().size(), aside < 0.5 * kDetail ? 1U : 0U) << aside;
  }
}

// Haze of which nothing is seen is nothing to a tool that starts in it.
TEST(Haze, IsNotFeltWhereTheToolStartsInIt) {
  const SceneIndex index(
      test::scene_of({test::splat({0, 0, 0}, {0.05, 0.05, 0.05}, Eigen::Quaterniond::Identity(), 0.3)}),
      SceneFilter{}, Similarity{});
  const Tool tool(Vector3d::Constant(kRadius));
  ContactSet touched;
  query(index, tool, {{0.02, 0, 0.04}, Eigen::Quaterniond::Identity()}, touched);
  EXPECT_FALSE(touched.contacts.empty());
  ProxyForce model(index, tool, {.stiffness = kUsualStiffness});
  ForceInput input;
  input.dt = 1e-3;
  for (double z = 0.04; z > -0.04; z -= 1e-4) {
    input.tool.position = {0.02, 0, z};
    EXPECT_EQ(model.evaluate(input).wrench.force, Vector3d(0, 0, 0)) << z;
  }
}

// Past the edge of half a sheet, which reaches a millimetre into the ball's flank, and back: it goes round
// the edge, and hangs on it in neither direction.
TEST(SurfacePatches, ABallSlipsPastAnEdge) {
  auto half = sheet(0.8);
  std::erase_if(half, [](const test::Splat& splat) { return splat.position.x() > 0.0; });
  const SceneIndex index(test::scene_of(half), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
  ForceInput input;
  input.dt = 1e-3;
  const double edge = 0.65 * kSpacing;  // what is drawn goes on a little
  double most = 0.0;
  for (int tick = 0; tick <= 1600; ++tick) {
    const double z = tick <= 800 ? 0.04 - 1e-4 * tick : -0.12 + 1e-4 * tick;
    input.tool.position = {edge + kRadius - 0.001, 0.0003, z};
    most = std::max(most, model.evaluate(input).wrench.force.norm());
  }
  EXPECT_LT(most, kUsualStiffness * 0.006);
}

// A proxy that has nothing in its way any more comes back no faster than twice the tool moves, however far it
// could cross the free space: 100 mm above a ball that has gone past the edge of what holds it, at 10 m/s.
TEST(SurfacePatches, AProxyThatIsFreeAgainFollowsInItsTime) {
  auto half = sheet(0.95);
  std::erase_if(half, [](const test::Splat& splat) { return splat.position.x() > 0.0; });
  const SceneIndex index(test::scene_of(half), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
  ForceInput input;
  input.dt = 1e-3;
  Vector3d at(-0.03, 0, kRadius + 0.01), proxy = at;
  const auto move = [&](const Vector3d& by) {
    at += by;
    input.tool.position = at;
    input.velocity.linear = by / input.dt;
    const Vector3d before = std::exchange(proxy, model.evaluate(input).proxy.position);
    return (proxy - before).norm();
  };
  while (at.z() > -0.08) move({0, 0, -1e-4});
  EXPECT_NEAR(proxy.z(), kRadius, 0.001);
  const double moved = 0.01;
  for (int tick = 0; tick < 20; ++tick) EXPECT_LE(move({moved, 0, 0}), 2.0 * moved + 1e-9) << tick;
  EXPECT_EQ(proxy, at);
}

// Paper eq. 9 with the opacity that is seen. 2 pi 0.65^2 = 2.65 splats lie over each other: of opacity 0.2
// they hide 1 - 0.8^2.65 = 0.446 in the mean, which is less than half; of 0.3 they hide 0.61, (0.61 - 0.5) /
// 0.4 of the way from half to what counts as opaque.
TEST(Confidence, FollowsTheOpacityThatIsSeen) {
  EXPECT_LT(press(sheet(0.2), 0.0, 0.005).wrench.force.z(), 0.1 * kUsualStiffness * 0.005);
  const ForceOutput thin = press(sheet(0.3), 0.0, 0.005);
  EXPECT_NEAR(thin.confidence, 0.5 + 0.5 * 0.275, 0.1);
  EXPECT_NEAR(thin.wrench.force.z(), 0.6375 * kUsualStiffness * 0.005, 0.2 * kUsualStiffness * 0.005);
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

// Half for what is seen at all; the rest by how much of an eighth or a quarter of the rays meet something,
// the smooth step of 1/2 being 1/2, and by how far what they meet hides from a half to nine tenths of the
// light.
TEST(Confidence, IsByWhatIsCoveredAndHidden) {
  DepthMoments moments;
  moments.aimed = 4.0F;
  EXPECT_EQ(confidence_of(moments, false), 0.0);
  EXPECT_EQ(confidence_of(moments, true), 0.5);
  const auto of = [&](float covered, float through) {
    moments.hit = covered * moments.aimed;
    moments.seen_through = through * moments.hit;
    return confidence_of(moments, true);
  };
  EXPECT_NEAR(of(1.0F, 0.05F), 1.0, 1e-6);
  EXPECT_NEAR(of(0.25F, 0.1F), 1.0, 1e-6);
  EXPECT_NEAR(of(1.0F, 0.3F), 0.75, 1e-6);
  EXPECT_NEAR(of(0.125F, 0.0F), 0.75, 1e-6);
  EXPECT_NEAR(of(0.125F, 0.3F), 0.625, 1e-6);
  EXPECT_NEAR(of(1.0F, 0.6F), 0.5, 1e-6);
}

// One that nothing hides and that hides nothing but itself is felt softly; what no ray sees is not felt.
TEST(Confidence, OfAContactIsAHalfWhereItFloatsAndNoneWhereNothingIsSeen) {
  const Tool tool(Vector3d::Constant(kRadius));
  const Pose pose{{0, 0, 0.018}, Eigen::Quaterniond::Identity()};
  ContactSet set;
  const auto of = [&](const std::vector<test::Splat>& splats) {
    const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
    query(index, tool, pose, set);
    EXPECT_FALSE(set.contacts.empty());
    return confidence(index, tool, pose, {}, set.contacts);
  };
  for (const double c : of({test::splat({0, 0, 0}, {0.003, 0.003, 0.003})})) {
    EXPECT_GE(c, 0.5);
    EXPECT_LE(c, 0.65);
  }
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  for (const double c : of({test::splat({0, 0, 0}, {0.05, 0.05, 1e-4}, straight, 0.2)})) EXPECT_EQ(c, 0.0);
}

// It is seen in its middle, as splatting draws it.
TEST(Confidence, IsNotLostWhereAllGaussiansAreLarge) {
  const std::vector<test::Splat> one{test::splat({0, 0, -0.1}, {0.1, 0.1, 0.1})};
  const ForceOutput felt = press(one, -0.1, 0.005);
  EXPECT_GT(felt.confidence, 0.9);
  EXPECT_GT(felt.wrench.force.z(), 0.8 * kUsualStiffness * 0.005);
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
    EXPECT_NEAR(felt.wrench.force.z(), felt.confidence * kUsualStiffness * depth,
                0.1 * kUsualStiffness * depth);
  }
}

// What a hand that trembles has come through takes light away, too, and the first veil is behind the ball
// when it comes to the second.
TEST(Haze, IsFeltByAHandThatTrembles) {
  constexpr double kUp = 0.3;  // of all of it above the origin
  for (const double apart : {0.04, 0.08}) {
    std::vector<test::Splat> veils;
    for (int k = 0; k < 3; ++k)
      veils.push_back(
          test::splat({0, 0, kUp - apart * k}, {0.3, 0.3, 1e-5}, Eigen::Quaterniond::Identity(), 0.3));
    const SceneIndex index(test::scene_of(veils), SceneFilter{}, Similarity{});
    for (const double aside : {0.0, 5e-5}) {  // aslant by 27 degrees, to one side and the other
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
      ForceInput input;
      input.dt = 1e-3;
      ForceOutput felt;
      const auto to = [&](double height) {
        for (; input.tool.position.z() > kUp + height; input.tool.position.z() -= 1e-4) {
          input.tool.position.x() = aside - input.tool.position.x();
          felt = model.evaluate(input);
        }
      };
      input.tool.position = {0, 0, kUp + 0.05};
      to(-apart + kRadius + 0.001);
      EXPECT_EQ(felt.wrench.force.norm(), 0.0) << aside;
      to(-apart + kRadius - 0.005);
      EXPECT_GT(felt.wrench.force.z(), 0.4 * kUsualStiffness * 0.005) << aside;
    }
  }
}

// A veil that a tool has come through takes light from what is ahead, however far, and from nothing beside it
// that the tool goes to through empty space, fast or slowly.
TEST(Haze, IsLeftBehindWhereTheToolGoesAnotherWay) {
  constexpr double kAside = 0.5, kVeil = 1.0, kBetween = 0.5, kFaint = 0.2, kIn = 0.005;
  const auto disc = [](double y, double z, double opacity) {
    return test::splat({0.0, y, z}, {0.05, 0.05, 1e-5}, Eigen::Quaterniond::Identity(), opacity);
  };
  const SceneIndex index(
      test::scene_of({disc(0.0, kVeil, 0.35), disc(0.0, 0.0, kFaint), disc(kAside, 0.0, kFaint)}),
      SceneFilter{}, Similarity{});
  const auto force_at = [&](double aside, double step) {
    ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    ForceOutput felt;
    const auto to = [&](const Vector3d& end, double longest) {
      while (input.tool.position != end) {
        const Vector3d way = end - input.tool.position;
        input.tool.position =
            way.norm() > longest ? Vector3d(input.tool.position + longest * way.normalized()) : end;
        felt = model.evaluate(input);
      }
    };
    input.tool.position = {0.0, 0.0, kVeil + 0.1};
    to({0.0, 0.0, kBetween}, 1e-4);
    EXPECT_EQ(felt.wrench.force.norm(), 0.0);
    to({0.0, aside, kBetween}, step);
    to({0.0, aside, kRadius - kIn}, 1e-4);
    return felt.wrench.force.z();
  };
  EXPECT_GT(force_at(0.0, 1e-3), 0.4 * kUsualStiffness * kIn);
  for (const double step : {0.001, 0.01, 0.05, 0.5}) EXPECT_EQ(force_at(kAside, step), 0.0) << step;
}

// What a veil has hidden of h of the light gives way, where there is none any more, over half a detail times
// the square of how hazy it is, 2 (1 - confidence): what is seen behind it is felt from there on, but for
// exp(-way / that).
TEST(Haze, GivesWayAsTheToolMovesAlongIt) {
  constexpr double kDetail = 0.01, kDrop = 0.002, kAbove = 0.0005, kFar = 0.2;  // from the origin
  const auto disc = [&](double z, double opacity) {
    return std::vector{test::splat({kFar, 0, z}, {0.5, 0.5, 1e-6}, Eigen::Quaterniond::Identity(), opacity)};
  };
  for (const double hidden : {0.48, 0.7, 0.9}) {
    const double confidence = 0.5 + 0.5 * std::max(0.0, hidden - 0.5) / 0.4;
    const double held = 0.5 * kDetail * std::pow(2.0 * (1.0 - confidence), 2);
    for (const double way : {0.0005, 0.002, 0.005}) {
      Feeler ball(disc(0.0, hidden), Vector3d::Constant(kRadius), kDetail),
          behind(disc(-kDrop, 0.95), ball.axes, kDetail);
      ball.look_down({kFar, 0, kRadius + kAbove}, 0.002);
      ASSERT_EQ(ball.patches.patches().size(), 1U);
      const SurfacePatch& patch = ball.patches.patches()[0];
      EXPECT_NEAR(patch.confidence, confidence, 1e-3);
      EXPECT_NEAR(patch.gap, kAbove, 1e-5);
      const Vector3d at(kFar + way, 0, kRadius + kAbove);
      ball.patches.follow(behind.around(at), ball.solid(at));
      ASSERT_EQ(ball.patches.patches().size(), 1U);
      EXPECT_NEAR(patch.gap, kAbove + kDrop * (1.0 - std::exp(-way / std::max(held, 1e-9))), 0.01 * kDrop)
          << hidden << " " << way;
    }
  }
}

// A mist of thin discs that are turned and placed by lot is less dense to a look against the normal of what
// is found than along the way that the ball came. What it has met is there while it is pressed in, unless it
// slips off to the side, as it may from one disc in a few.
TEST(Haze, IsNotLostWhileItIsPressed) {
  struct Mist {
    double opacity, size;
  };
  int felt = 0, lost = 0;
  for (const Mist& mist : {Mist{0.2, 0.008}, Mist{0.15, 0.01}}) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Random random(seed);
      std::vector<test::Splat> discs;
      for (int k = 0; k < 100; ++k) {
        const Vector3d at{random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(-0.04, 0)};
        const double w = random.uniform(-1, 1), x = random.uniform(-1, 1), y = random.uniform(-1, 1),
                     z = random.uniform(-1, 1);
        discs.push_back(test::splat(at, {mist.size, mist.size, 1e-4},
                                    Eigen::Quaterniond(w, x, y, z).normalized(), mist.opacity));
      }
      const SceneIndex index(test::scene_of(discs), SceneFilter{}, Similarity{});
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
      ForceInput input;
      input.dt = 1e-3;
      std::optional<double> met;
      bool silent = false;
      for (double z = 0.05; z > -0.03 && !(met && z < *met - 0.01); z -= 1e-4) {
        input.tool.position = {0, 0, z};
        const double force = model.evaluate(input).wrench.force.norm();
        if (!met && force > 0.0) met = z;
        silent |= met && *met - z > 0.003 && force < 0.05 * kUsualStiffness * (*met - z);
      }
      felt += met ? 1 : 0;
      lost += silent ? 1 : 0;
    }
  }
  EXPECT_GT(felt, 40);
  EXPECT_LT(4 * lost, felt) << felt;
}

// What a client is told of a surface that the tool has just left: its stiffness as it was felt.
TEST(Confidence, IsInTheStiffnessOfWhatIsNotTouched) {
  for (const double opacity : {0.5, 0.95}) {
    const SceneIndex index(test::scene_of(sheet(opacity)), SceneFilter{}, Similarity{});
    ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kUsualStiffness});
    ForceInput input;
    input.dt = 1e-3;
    const auto go = [&](int from, int to) {
      ForceOutput felt;
      for (int k = from; k != to; k += from < to ? 1 : -1) {
        input.tool.position = {0.0, 0.0, kRadius - 1e-4 * k};
        felt = model.evaluate(input);
      }
      return felt;
    };
    const ForceOutput felt = go(-100, 30), left = go(30, -2);  // 0.1 mm above: the ellipsoids reach there
    ASSERT_GE(left.local.count, 1U);
    EXPECT_EQ(left.wrench.force.norm(), 0.0);
    EXPECT_NEAR(left.local.stiffness, felt.local.stiffness, 0.1 * felt.local.stiffness);
    EXPECT_NEAR(felt.local.stiffness, felt.confidence * kUsualStiffness, 0.01 * kUsualStiffness);
    if (opacity < 0.9) {
      EXPECT_LT(felt.confidence, 0.9);
    }
  }
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

// As many regions as there may be, all but one of them elsewhere.
TEST(ProxyMaterials, OfManyRegionsAreFeltAsOfOne) {
  std::vector<MaterialRegion> regions{{MaterialRegion::Everywhere{}, {.stiffness = 1200.0}}};
  const double alone = [&] {
    ProxyParameters parameters;
    parameters.materials = std::make_shared<MaterialMap>(regions);
    return press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z();
  }();
  while (regions.size() < 256) regions.push_back({MaterialSphere{{5.0, 0.0, 0.0}, 0.1}, {.stiffness = 1.0}});
  ProxyParameters parameters;
  parameters.materials = std::make_shared<MaterialMap>(regions);
  EXPECT_NEAR(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z(), alone, 1e-3 * alone);
}

TEST(ProxyMaterials, NothingIsFeltOfWhatHasNoStiffnessHoweverItDamps) {
  ProxyParameters parameters;
  parameters.materials = everywhere({.stiffness = 0.0, .damping = 3.0});
  EXPECT_EQ(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force, Vector3d(0, 0, 0));
}

TEST(ProxyMaterials, DampingAddsToThePushWhileTheToolGoesIn) {
  ProxyParameters parameters;
  parameters.materials = everywhere({.damping = 3.0});
  // At 0.1 m/s inwards, 3 N s/m.
  EXPECT_NEAR(press(sheet(0.8), 0.0, 0.005, parameters).wrench.force.z(), kUsualStiffness * 0.005 + 0.3,
              0.03 * kUsualStiffness * 0.005);
}

}  // namespace
}  // namespace palpate
