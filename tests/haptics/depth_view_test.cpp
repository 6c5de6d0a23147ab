// What a few rays see of the Gaussians around a tool, against the same composited in double precision.

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/splat_tracker.h>
#include <palpate/haptics/depth_view.h>
#include <palpate/haptics/seen_surface.h>
#include <palpate/scene/random.h>
#include <support/on_every_target.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadius = 0.02, kReach = 0.02;

Ellipsoid ball(const Vector3d& center, double radius) {
  return Ellipsoid::from_semi_axes({center, Eigen::Quaterniond::Identity()}, Vector3d::Constant(radius));
}

/// Small, tilted discs below the origin, each at a depth of its own, so that the order along a ray is beyond
/// doubt.
std::vector<test::Splat> layered(Random& random, int count) {
  std::vector<test::Splat> splats;
  for (int i = 0; i < count; ++i) {
    const Vector3d at(random.uniform(-0.015, 0.015), random.uniform(-0.015, 0.015), -0.005 - 6e-4 * i);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(
        0.003 * random.normal(), Vector3d(random.normal(), random.normal(), 0).normalized()));
    splats.push_back(test::splat(at, {random.uniform(0.002, 0.006), random.uniform(0.002, 0.006), 1e-5}, turn,
                                 random.uniform(0.2, 0.95)));
  }
  return splats;
}

using DepthViewTest = test::OnEveryTarget;

TEST_F(DepthViewTest, SeesWhatCompositingInDoubleSees) {
  Random random(41);
  const auto image = std::make_unique<DepthView>();
  for (int scene = 0; scene < 20; ++scene) {
    const auto splats = layered(random, 40);
    const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
    const SeenSurface seen(test::scene_of(splats), Similarity{});
    const Ellipsoid solid = ball(Vector3d::Zero(), kRadius),
                    larger = ball(Vector3d::Zero(), kRadius + kReach);
    SplatTracker tracker(index);
    const LocalSplats& near = tracker.around(larger);
    const ViewFrame view = ViewFrame::along(-Vector3d::UnitZ(), Vector3d::Zero(), Vector3d::UnitX());
    Vector2d anchor(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const RayPattern pattern = RayPattern::on_lattice({0.001, -0.002}, 0.015, anchor);
    on_every_target([&] {
      RayLight light;
      image->look(near, view, Profile(solid, view), larger, pattern, 0.0, light);
      int hits = 0, agree = 0;
      for (std::size_t k = 0; k < DepthView::kRays; ++k) {
        if (k >= pattern.size && k < DepthView::kRegular) continue;
        const auto expected = seen.depth(view.at(image->x(k), image->y(k), 0.0), view.w);
        ++hits;
        // Where about half of the light is left, what is drawn of a Gaussian that is all but invisible there
        // decides.
        agree += expected ? std::abs(image->depth(k) - *expected) < 2e-6 : !image->hits(k);
      }
      EXPECT_GE(hits, 50);
      EXPECT_GE(agree, hits - 3);
    });
  }
}

TEST_F(DepthViewTest, ClearanceIsFromTheSolidToWhatIsSeen) {
  const SceneIndex index(test::scene_of({test::splat({0, 0, -0.03}, {0.02, 0.02, 1e-5})}), SceneFilter{},
                         Similarity{});
  const Ellipsoid solid = ball(Vector3d::Zero(), kRadius), larger = ball(Vector3d::Zero(), kRadius + kReach);
  SplatTracker tracker(index);
  const LocalSplats& near = tracker.around(larger);
  const auto image = std::make_unique<DepthView>();
  const ViewFrame view = ViewFrame::along(-Vector3d::UnitZ(), Vector3d::Zero(), Vector3d::UnitX());
  Vector2d anchor = Vector2d::Zero();
  on_every_target([&] {
    RayLight light;
    image->look(near, view, Profile(solid, view), larger, RayPattern::on_lattice({0, 0}, 0.01, anchor), 0.0,
                light);
    const std::size_t nearest = image->nearest();
    ASSERT_LT(nearest, DepthView::kRays);
    EXPECT_NEAR(image->clearance(nearest), 0.01, 1e-6);  // straight below
    for (std::size_t k = 0; k < DepthView::kRays; ++k) {
      const double x = image->x(k), y = image->y(k);
      if (!image->hits(k)) continue;
      EXPECT_NEAR(image->clearance(k), 0.03 - std::sqrt(kRadius * kRadius - x * x - y * y), 1e-6);
    }
  });
}

TEST(RayPattern, LatticeStaysWhereItIsAsTheDiscMoves) {
  Random random(42);
  for (int i = 0; i < 1000; ++i) {
    const double radius = random.uniform(0.001, 0.1);
    Vector2d anchor(random.uniform(-1, 1), random.uniform(-1, 1)), moved_anchor = anchor;
    const Vector2d center(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    const RayPattern one = RayPattern::on_lattice(center, radius, anchor);
    EXPECT_GE(one.size, 45U);
    EXPECT_LT(one.size, RayPattern::kMost);  // so that none has been left out
    EXPECT_LT((anchor - center).norm(), 0.3 * radius);
    const Vector2d way = 0.05 * radius * Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
    const RayPattern other = RayPattern::on_lattice(center + way, radius, moved_anchor);
    for (std::size_t k = 0; k < one.size; ++k) {
      const Vector2d place = one.places[k].cast<double>();
      if ((place - center - way).norm() > 0.999 * radius) continue;  // gone at the rim
      double nearest = 1.0;
      for (std::size_t j = 0; j < other.size; ++j)
        nearest = std::min(nearest, (other.places[j].cast<double>() - place).norm());
      EXPECT_LT(nearest, 1e-5 * radius + 1e-6);
    }
  }
}

TEST(SplatTracker, KnowsAllThatTheSolidTouchesWhereverItGoes) {
  Random random(43);
  std::vector<test::Splat> splats;
  for (int i = 0; i < 3000; ++i)
    splats.push_back(
        test::splat({random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)},
                    {random.uniform(0.0, 0.01), random.uniform(0.0, 0.002), 0.001}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  SplatTracker tracker(index);
  ContactSet touched;
  Vector3d at = Vector3d::Zero();
  for (int step = 0; step < 300; ++step) {
    at += 0.003 * Vector3d(random.normal(), random.normal(), random.normal());
    const Ellipsoid solid = ball(at, 0.02);
    const LocalSplats& near = tracker.around(solid);
    index.query(solid, touched);
    for (const Contact& contact : touched.contacts) {
      std::size_t i = 0;
      while (i < near.size && near.id[i] != contact.id) ++i;
      ASSERT_LT(i, near.size);
      EXPECT_LT((near.position(i) - contact.center).norm(), 1e-7);
    }
  }
}

/// What a ray through the middle of a ball at the origin sees, looking down.
struct MiddleRay {
  explicit MiddleRay(const std::vector<test::Splat>& splats)
      : index(test::scene_of(splats), SceneFilter{}, Similarity{}), tracker(index) {}

  /// From a ball whose centre is at the height `z`; \returns the height of what is seen.
  double look(double z, RayLight& light) {
    const Vector3d center(0, 0, z);
    const Ellipsoid solid = ball(center, kRadius), larger = ball(center, kRadius + kReach);
    const ViewFrame view = ViewFrame::along(-Vector3d::UnitZ(), center, Vector3d::UnitX());
    const RayPattern pattern = RayPattern::over_ellipse(kRadius * Eigen::Matrix2d::Identity(), {0, 0});
    image->look(tracker.around(larger), view, Profile(solid, view), larger, pattern, 0.0, light);
    return z - image->depth(DepthView::kRegular);
  }

  SceneIndex index;
  SplatTracker tracker;
  std::unique_ptr<DepthView> image = std::make_unique<DepthView>();
};

// Splats of a capture are flat and wide: what is below the ball may have its centre far away from it.
TEST_F(DepthViewTest, SeesAWideDiscWhoseCentreIsFarAside) {
  on_every_target([&] {
    MiddleRay ray({test::splat({0.08, 0.01, -0.03}, {0.1, 0.1, 1e-5}, Eigen::Quaterniond::Identity(), 0.95)});
    RayLight light;
    EXPECT_NEAR(ray.look(0.0, light), -0.03, 1e-6);
  });
}

// Veils of opacity 0.2 let 0.8, 0.64, 0.512 and then 0.41 of the light through: the fourth is seen, for a
// ball that has come through the ones before as for one that looks at all of them.
TEST_F(DepthViewTest, WhatTheToolHasComeThroughTakesLightAway) {
  std::vector<test::Splat> veils;
  for (int k = 0; k < 6; ++k)
    veils.push_back(test::splat({0, 0, -0.005 * k}, {0.5, 0.5, 1e-6}, Eigen::Quaterniond::Identity(), 0.2));
  on_every_target([&] {
    MiddleRay ray(veils);
    RayLight light;
    EXPECT_NEAR(ray.look(0.002, light), -0.015, 1e-6);
    EXPECT_NEAR(light.left[0], 1.0, 1e-6);
    // 9 mm lower, two veils are above the ball's centre, where it looks from.
    light.since -= 0.009;
    EXPECT_NEAR(ray.look(-0.007, light), -0.015, 1e-6);
    EXPECT_NEAR(light.left[0], 0.64, 1e-3);
    RayLight fresh;
    EXPECT_NEAR(ray.look(-0.007, fresh), -0.025, 1e-6) << "for one that starts there, the fourth from there";
    // Nothing is felt twice: what has taken more than half is as what has taken half.
    light.since -= 0.011;
    EXPECT_NEAR(ray.look(-0.018, light), -0.020, 1e-6);
    EXPECT_EQ(light.left[0], 0.5F);
  });
}

TEST(SeenSurface, IsWhereTheTransmittanceFallsBelowOneHalf) {
  // Along z: of 0.4 and 0.4, 0.36 is left; of the second alone 0.6 would be.
  const std::vector<test::Splat> two{
      test::splat({0, 0, 0.1}, {0.01, 0.01, 1e-4}, Eigen::Quaterniond::Identity(), 0.4),
      test::splat({0, 0, 0.2}, {0.01, 0.01, 1e-4}, Eigen::Quaterniond::Identity(), 0.4)};
  const SeenSurface seen(test::scene_of(two), Similarity{});
  EXPECT_NEAR(seen.depth({0, 0, 0}, Vector3d::UnitZ()).value(), 0.2, 1e-7);
  // 0.4 exp(-1 / 2) = 0.243 twice leaves 0.573.
  EXPECT_FALSE(seen.depth({0.01, 0, 0}, Vector3d::UnitZ()).has_value());
  EXPECT_FALSE(seen.depth({0, 0, 0}, -Vector3d::UnitZ()).has_value()) << "behind";
  // A ball of 50 mm meets it with its lowest point.
  EXPECT_NEAR(seen.first_touch(Tool(Vector3d::Constant(0.05)), {0, 0, 0}, Vector3d::UnitZ()).value(), 0.15,
              1e-7);
  // One that goes past it at 30 mm meets it with its side, 40 mm below its centre.
  const std::vector<test::Splat> speck{test::splat({0.03, 0, 0.2}, {0.004, 0.004, 1e-4})};
  const SeenSurface beside(test::scene_of(speck), Similarity{});
  EXPECT_NEAR(beside.first_touch(Tool(Vector3d::Constant(0.05)), {0, 0, 0}, Vector3d::UnitZ()).value(), 0.16,
              0.003);
}

}  // namespace
}  // namespace palpate
