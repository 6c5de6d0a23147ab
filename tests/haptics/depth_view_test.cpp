// What a few rays see of the Gaussians around a tool, against the same composited in double precision.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/splat_tracker.h>
#include <palpate/geometry/rotation.h>
#include <palpate/haptics/depth_view.h>
#include <palpate/study/random.h>
#include <palpate/study/seen_surface.h>
#include <support/ball_on_surface.h>
#include <support/on_every_target.h>
#include <support/solids.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ball;
using test::kRadius;

constexpr double kReach = 0.02;

/// Small, tilted discs below the origin, each at a depth of its own, so that the order along a ray is beyond
/// doubt.
std::vector<test::Splat> layered(Random& random, int count) {
  std::vector<test::Splat> splats;
  for (int i = 0; i < count; ++i) {
    const Vector3d at{random.uniform(-0.015, 0.015), random.uniform(-0.015, 0.015), -0.005 - 6e-4 * i};
    const double angle = 0.003 * random.normal();
    const Vector3d axis = Vector3d{random.normal(), random.normal(), 0.0}.normalized();
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis));
    const Vector3d semi_axes{random.uniform(0.002, 0.006), random.uniform(0.002, 0.006), 1e-5};
    splats.push_back(test::splat(at, semi_axes, turn, random.uniform(0.2, 0.95)));
  }
  return splats;
}

/// A ball at the origin that looks down on splats.
struct LooksDown {
  explicit LooksDown(const test::Splat& splat) : LooksDown(std::vector{splat}) {}
  explicit LooksDown(const std::vector<test::Splat>& splats)
      : index(test::scene_of(splats), SceneFilter{}, Similarity{}), tracker(index) {}

  void render(const RayPattern& pattern) {
    RayLight light;
    image->render(tracker.around(larger), view, profile, larger, pattern, 0.0, light);
  }

  SceneIndex index;
  SplatTracker tracker;
  Ellipsoid solid = ball(Vector3d::Zero(), kRadius), larger = ball(Vector3d::Zero(), kRadius + kReach);
  ViewFrame view = ViewFrame::along(-Vector3d::UnitZ(), Vector3d::Zero(), Vector3d::UnitX());
  Profile profile{solid, view};
  std::unique_ptr<DepthView> image = std::make_unique<DepthView>();
};

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
    Vector2d anchor{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
    const RayPattern pattern = RayPattern::on_lattice({0.001, -0.002}, 0.015, anchor);
    on_every_target([&] {
      RayLight light;
      image->render(near, view, Profile(solid, view), larger, pattern, 0.0, light);
      int hits = 0, agree = 0;
      for (std::size_t k = 0; k < DepthView::kRays; ++k) {
        if (k >= pattern.size && k < DepthView::kRegular) continue;
        const Vector3d from = view.at(image->x(k), image->y(k), 0.0);
        const auto depth_at = [&](double light) {
          return seen.depth(from, view.w, light * DepthView::kSeen);
        };
        const auto expected = depth_at(1.0);
        // Where about as much of the light is left, what is drawn of a Gaussian that is all but invisible
        // there decides.
        if (depth_at(0.98) != depth_at(1.02)) continue;
        ++hits;
        agree += expected ? std::abs(image->depth(k) - *expected) < 2e-6 : !image->hits(k);
      }
      EXPECT_GE(hits, 50);
      EXPECT_EQ(agree, hits);
    });
  }
}

TEST_F(DepthViewTest, ClearanceIsFromTheSolidToWhatIsSeen) {
  LooksDown ball(test::splat({0, 0, -0.03}, {0.02, 0.02, 1e-5}));
  const auto& image = ball.image;
  Vector2d anchor = Vector2d::Zero();
  on_every_target([&] {
    ball.render(RayPattern::on_lattice({0, 0}, 0.01, anchor));
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

// What is outside of the larger ball, 40 mm, counts as not there: of a disc 30 mm below its centre, what
// is 26.5 mm aside.
TEST_F(DepthViewTest, SeesNothingOutsideOfTheLargerSolid) {
  LooksDown ball(test::splat({0, 0, -0.03}, {0.5, 0.5, 1e-5}, Eigen::Quaterniond::Identity(), 0.95));
  Vector2d anchor = Vector2d::Zero();
  const RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.038, anchor);
  on_every_target([&] {
    ball.render(pattern);
    std::size_t hits = 0;
    for (std::size_t k = 0; k < pattern.size; ++k) {
      const double aside = std::hypot(ball.image->x(k), ball.image->y(k));
      EXPECT_EQ(ball.image->hits(k), aside < std::sqrt(0.0007)) << k;
      hits += ball.image->hits(k) ? 1 : 0;
    }
    EXPECT_GT(hits, 10U);
    EXPECT_LT(hits, pattern.size - 10);
  });
}

// What is known to be there is seen although the look begins behind it.
TEST_F(DepthViewTest, SeesWhatIsKnownWhereverItBegins) {
  LooksDown ball(test::splat({0, 0, 0.005}, {0.05, 0.05, 1e-5}, Eigen::Quaterniond::Identity(), 0.95));
  Vector2d anchor = Vector2d::Zero();
  const RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.01, anchor);
  on_every_target([&] {
    RayLight light;
    ball.render(pattern);
    EXPECT_FALSE(ball.image->hits(DepthView::kRegular));
    ball.image->render(ball.tracker.around(ball.larger), ball.view, ball.profile, ball.larger, pattern, 0.0,
                       light, -0.01);
    EXPECT_NEAR(ball.image->depth(DepthView::kRegular), -0.005, 1e-6);
    EXPECT_EQ(light.since, -0.01);
  });
}

// A veil before the place where the look begins takes from each ray what it hides of that one: 0.4 exp(-m^2 /
// 2), out to where that is a 255th.
TEST_F(DepthViewTest, EachRayLosesTheLightThatIsHiddenFromIt) {
  constexpr double kSigma = 0.003;
  LooksDown ball(
      test::splat({0.004, 0.003, 0.008}, {kSigma, kSigma, 1e-6}, Eigen::Quaterniond::Identity(), 0.4));
  Vector2d anchor = Vector2d::Zero();
  const RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.015, anchor);
  on_every_target([&] {
    RayLight light;
    light.since = -0.01;
    ball.image->render(ball.tracker.around(ball.larger), ball.view, ball.profile, ball.larger, pattern, 0.0,
                       light);
    double least = 1.0;
    for (std::size_t k = 0; k < pattern.size; ++k) {
      const double m = std::hypot(ball.image->x(k) - 0.004, ball.image->y(k) + 0.003) / kSigma;
      EXPECT_NEAR(light.left[k], m < 3.3 ? 1.0 - 0.4 * std::exp(-0.5 * m * m) : 1.0, 5e-3) << k;
      least = std::min(least, static_cast<double>(light.left[k]));
    }
    EXPECT_LT(least, 0.7);
    EXPECT_EQ(light.since, 0.0);
  });
}

// Rays that are no regular ones have the light of the regular one that is nearest.
TEST_F(DepthViewTest, LightIsThatOfTheNearestRay) {
  LooksDown ball(test::splat({0.004, 0.002, -0.03}, {1e-4, 1e-4, 1e-5}));
  Vector2d anchor = Vector2d::Zero();
  RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.015, anchor);
  on_every_target([&] {
    for (const Vector2d& aim : {Vector2d(0.001, 0.009), Vector2d(0.002, -0.009), Vector2d(-0.008, 0.003)}) {
      pattern.aim = aim;
      RayLight light;
      for (std::size_t k = 0; k < pattern.size; ++k)
        light.left[k] = 0.5F + 0.5F * static_cast<float>(k) / static_cast<float>(pattern.size);
      const RayLight given = light;
      const DepthView& image = *ball.image;
      ball.image->render(ball.tracker.around(ball.larger), ball.view, ball.profile, ball.larger, pattern, 0.0,
                         light);
      for (std::size_t k = DepthView::kRegular; k < DepthView::kRegular + 3; ++k) {
        const auto away = [&](std::size_t i) {
          return std::hypot(image.x(i) - image.x(k), image.y(i) - image.y(k));
        };
        std::size_t nearest = 0;
        for (std::size_t i = 1; i < pattern.size; ++i)
          if (away(i) < away(nearest)) nearest = i;
        EXPECT_EQ(image.incoming(k), given.left[nearest]) << k;
      }
    }
  });
}

// Specks that no regular ray need meet are seen, all of a few and the nearest of many.
TEST_F(DepthViewTest, SeesTheSpecksThatAreNearest) {
  constexpr std::size_t kSought = DepthView::kSought - 2;
  Random random(45);
  for (const std::size_t count : {std::size_t{5}, kSought, std::size_t{60}}) {
    std::vector<test::Splat> specks;
    std::vector<double> clearances;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 2.39996 * static_cast<double>(i),
                   r = 0.002 + 0.01 * std::sqrt(random.uniform(0.0, 1.0));
      const Vector3d at(r * std::cos(angle), r * std::sin(angle), random.uniform(-0.035, -0.025));
      specks.push_back(test::splat(at, {2e-5, 2e-5, 2e-5}, Eigen::Quaterniond::Identity(), 0.95));
      clearances.push_back(-at.z() - std::sqrt(kRadius * kRadius - r * r));
    }
    std::sort(clearances.begin(), clearances.end());
    clearances.resize(std::min(count, kSought));
    LooksDown ball(specks);
    Vector2d anchor = Vector2d::Zero();
    on_every_target([&] {
      ball.render(RayPattern::on_lattice({0, 0}, 0.015, anchor));
      for (const double clearance : clearances) {
        bool seen = false;
        for (std::size_t k = 0; k < DepthView::kRays; ++k)
          seen = seen || std::abs(ball.image->clearance(k) - clearance) < 1e-6;
        EXPECT_TRUE(seen) << clearance << " of " << count;
      }
    });
  }
}

/// Least clearance from a ball at the origin of the places of a needle, out to `reach` of its length, and of
/// its middle; see DepthView::clearance().
struct NeedleBelowTheBall {
  Vector3d middle, tip;

  double clearance(double part) const {
    const Vector3d at = middle + part * tip;
    const double aside = at.head<2>().squaredNorm();
    return aside < 0.97 * kRadius * kRadius ? -at.z() - std::sqrt(kRadius * kRadius - aside) : 1.0;
  }
  double least(double reach) const {
    double least = 1.0;
    for (int k = -100; k <= 100; ++k) least = std::min(least, clearance(0.01 * reach * k));
    return least;
  }
};

// A lone needle is seen where the ball meets it, be that its flank or its tip: where it hides half of the
// light. What is gained by less than a tenth of the ball does not count. Nowhere is it seen where it hides
// less than it takes to be seen.
TEST_F(DepthViewTest, SeesALoneNeedleWhereTheBallMeetsIt) {
  Random random(46);
  const auto reach = [](double opacity, double left) {
    return std::sqrt(2.0 * std::log(opacity / (1.0 - left)));
  };
  for (const double opacity : {0.6, 0.95}) {
    std::vector<double> late_at_middle;
    for (int i = 0; i < 300; ++i) {
      const double angle = random.uniform(-std::numbers::pi, std::numbers::pi),
                   r = random.uniform(0.0, 0.018);
      const Vector3d middle(r * std::cos(angle), r * std::sin(angle), random.uniform(-0.035, -0.022));
      const Vector3d along = Vector3d{random.normal(), random.normal(), random.normal()}.normalized();
      const double length = random.uniform(0.002, 0.02);
      const NeedleBelowTheBall needle{middle, length * along};
      LooksDown ball(
          test::splat(middle, {length, 2e-5, 2e-5}, rotation_between(Vector3d::UnitX(), along), opacity));
      Vector2d anchor = Vector2d::Zero();
      const double met = needle.least(std::min(1.0, reach(opacity, 0.5)));
      late_at_middle.push_back(needle.clearance(0.0) - met);
      on_every_target([&] {
        ball.render(RayPattern::on_lattice({0, 0}, 0.018, anchor));
        const std::size_t nearest = ball.image->nearest();
        ASSERT_LT(nearest, DepthView::kRays);
        const double seen = ball.image->clearance(nearest);
        EXPECT_LT(seen, met + 0.125 * kRadius) << i;
        EXPECT_GT(seen, needle.least(reach(opacity, DepthView::kSeen)) - 1e-4) << i;
      });
    }
    std::ranges::sort(late_at_middle);
    EXPECT_GT(late_at_middle[late_at_middle.size() * 3 / 4], 0.2 * kRadius) << "and it matters often";
  }
}

// A disc whose centre is beside the ball, or at its flank, and which reaches below it, is seen where the ball
// meets it, however steep it is. The search is of first order: of some, it misses that place.
TEST_F(DepthViewTest, SeesADiscThatReachesBelowTheBallFromTheSide) {
  Random random(47);
  int discs = 0, late = 0;
  for (int i = 0; i < 400; ++i) {
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi), r = random.uniform(0.019, 0.03),
                 radius = random.uniform(0.012, 0.02);
    const Vector3d middle(r * std::cos(angle), r * std::sin(angle), random.uniform(-0.03, -0.01));
    const Vector3d normal =
        (Vector3d::UnitZ() + 3.0 * Vector3d{random.normal(), random.normal(), 0.0}).normalized();
    const Eigen::Quaterniond turn = rotation_between(Vector3d::UnitZ(), normal);
    double met = 1.0;
    for (int k = 0; k < 360; ++k) {
      const double way = std::numbers::pi / 180.0 * k;
      const Vector3d rim = turn * Vector3d(radius * std::cos(way), radius * std::sin(way), 0.0);
      met = std::min(met, NeedleBelowTheBall{middle, rim}.least(1.0));
    }
    if (met < 0.0 || met > 0.02) continue;
    LooksDown ball(test::splat(middle, {radius, radius, 2e-5}, turn, 0.95));
    Vector2d anchor = Vector2d::Zero();
    ball.render(RayPattern::on_lattice({0, 0}, 0.018, anchor));
    const std::size_t nearest = ball.image->nearest();
    const double seen = nearest < DepthView::kRays ? ball.image->clearance(nearest) : 1.0;
    ++discs;
    late += seen > met + 0.125 * kRadius ? 1 : 0;
  }
  EXPECT_GT(discs, 100);
  EXPECT_LT(late, discs / 4);
}

// Thin ones that stand between two rows of rays, nearer to the one than to the other, and reach both: each
// hides little of the ray in the farther row that is straight above them, and all together hide it.
TEST_F(DepthViewTest, SeesWhatReachesARowOfRaysThatIsNotTheNearest) {
  constexpr double kCell = 0.26 * 0.015, kRow = 0.8660254 * kCell;
  std::vector<test::Splat> stack;
  for (int k = 0; k < 250; ++k)
    stack.push_back(test::splat({0.5 * kCell, -(kRow - 0.45 * kCell), -0.03 - 1e-6 * k},
                                {5e-5, 0.55 * kCell / 3.33, 1e-6}, Eigen::Quaterniond::Identity(), 0.99));
  LooksDown ball(stack);
  Vector2d anchor = Vector2d::Zero();
  const RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.015, anchor);
  on_every_target([&] {
    ball.render(pattern);
    std::size_t above = 0;
    for (std::size_t k = 0; k < pattern.size; ++k) {
      if (std::hypot(ball.image->x(k) - 0.5 * kCell, ball.image->y(k) - kRow) > 1e-6) continue;
      ++above;
      EXPECT_TRUE(ball.image->hits(k));
    }
    EXPECT_EQ(above, 1U);
  });
}

// Of an ellipsoid that is turned any way, by its own definition: |axes^-1 (point - center)| = 1, on the far
// side.
TEST(Profile, IsTheFarSideOfTheSolid) {
  Random random(44);
  int below = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond{random.normal(), random.normal(), random.normal(), random.normal()}.normalized();
    const Vector3d semi_axes{random.uniform(0.01, 0.05), random.uniform(0.01, 0.05),
                             random.uniform(0.01, 0.05)};
    const Ellipsoid solid = Ellipsoid::from_semi_axes({{1, 2, 3}, turn}, semi_axes);
    const Vector3d w = Vector3d{random.normal(), random.normal(), random.normal()}.normalized();
    const ViewFrame view = ViewFrame::along(w, solid.center, w.unitOrthogonal());
    const Profile profile(solid, view);
    const auto size = [&](double x, double y, double depth) {
      return (solid.axes.inverse() * (view.at(x, y, depth) - solid.center)).norm();
    };
    const auto x = static_cast<float>(random.uniform(-0.05, 0.05)),
               y = static_cast<float>(random.uniform(-0.05, 0.05));
    // The ray through (x, y) is nearest to the centre, by the solid's measure, where that is least.
    const Vector3d at = solid.axes.inverse() * (x * view.u + y * view.v), along = solid.axes.inverse() * w;
    const double least = (at - at.dot(along) / along.squaredNorm() * along).squaredNorm();
    if (std::abs(least - 1.0) < 0.01) continue;
    ASSERT_EQ(profile.below(x, y), least < 1.0);
    if (least > 1.0) continue;
    ++below;
    const double depth = profile.depth(x, y);
    EXPECT_NEAR(size(x, y, depth), 1.0, 1e-4);
    EXPECT_GT(size(x, y, depth + 1e-4), 1.0);
    EXPECT_LT(size(x, y, depth - 1e-4), 1.0);
  }
  EXPECT_GT(below, 100);
}

// At its very side a solid is steeper than a depth image can tell: a ray there has no clearance, whatever it
// sees.
TEST_F(DepthViewTest, HasNoClearanceAtTheSideOfTheSolid) {
  LooksDown ball(test::splat({0, 0, -0.03}, {0.05, 0.05, 1e-5}));
  const auto& image = ball.image;
  constexpr std::size_t kAimed = DepthView::kRegular + 1;
  on_every_target([&] {
    for (const double r : {0.9, 0.999, 0.9999, 1.01}) {
      Vector2d anchor = Vector2d::Zero();
      RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.03, anchor);
      pattern.aim = {0.0, r * kRadius};
      ball.render(pattern);
      EXPECT_EQ(image->clearance(kAimed) < DepthView::kNothing, r < 0.9998) << r;
      for (std::size_t k = 0; k < DepthView::kRays; ++k) {
        const bool below = image->hits(k) && ball.profile.below(image->x(k), image->y(k));
        EXPECT_EQ(image->clearance(k) < DepthView::kNothing, below) << k;
      }
    }
  });
}

// Of a large disc, opaque and aslant, which all light falls on at once: depths and light are those of the
// disc, and the sums are by the definition of DepthMoments, in double precision.
TEST_F(DepthViewTest, MomentsAreSumsOverTheRays) {
  const double slope = 0.2;
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(std::atan(slope), Vector3d::UnitY()));  // z = -0.03 - slope x
  LooksDown ball(test::splat({0, 0, -0.03}, {2.0, 2.0, 1e-5}, turn, 0.95));
  const auto& image = ball.image;
  const DepthKernel kernel{
      {0.001, -0.002}, 0.008, 0.031, 1.5F, {0.05F, 0.1F, -0.2F, 0.3F, -0.15F, 0.25F}, 0.4F};
  on_every_target([&] {
    Vector2d anchor = Vector2d::Zero();
    const RayPattern pattern = RayPattern::on_lattice({0, 0}, 0.015, anchor);
    ball.render(pattern);
    Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Vector<double, 6> right = Eigen::Vector<double, 6>::Zero();
    double hit = 0.0, residual = 0.0, aimed = 0.0, through = 0.0;
    for (std::size_t k = 0; k < pattern.size; ++k) {
      const double x = (image->x(k) - kernel.center.x()) / kernel.unit,
                   y = (image->y(k) - kernel.center.y()) / kernel.unit;
      const double z = (0.03 + slope * image->x(k) - kernel.level) / kernel.unit, r = x * x + y * y;
      const Eigen::Vector<double, 6> b{{1.0, x, y, r, x * x - y * y, 2.0 * x * y}};
      const double end = kernel.end, spread = kernel.spread;
      const double aim = std::pow(std::max(0.0, 1.0 - r / (end * end)), 3);
      double fit = 0.0;
      for (int i = 0; i < 6; ++i) fit += b[i] * kernel.fit[static_cast<std::size_t>(i)];
      const double off = z - fit, w = aim / (1.0 + off * off / (spread * spread));
      matrix += w * b * b.transpose();
      right += w * z * b;
      hit += w;
      residual += w * off * off;
      aimed += aim;
      through += 0.05 * w;
    }
    const DepthMoments found = image->moments(kernel);
    const double close = 1e-3 * hit;
    std::size_t at = 0;
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(found.right[static_cast<std::size_t>(i)], right[i], close) << i;
      for (int j = i; j < 6; ++j) EXPECT_NEAR(found.normal_matrix[at++], matrix(i, j), close) << i << j;
    }
    EXPECT_NEAR(found.hit, hit, close);
    EXPECT_NEAR(found.residual, residual, close);
    EXPECT_NEAR(found.aimed, aimed, close);
    EXPECT_NEAR(found.seen_through, through, close);
    EXPECT_GT(residual, 10.0 * close);
  });
}

TEST(RayPattern, LatticeStaysWhereItIsAsTheDiscMoves) {
  Random random(42);
  for (int i = 0; i < 1000; ++i) {
    const double radius = random.uniform(0.001, 0.1);
    Vector2d anchor{random.uniform(-1, 1), random.uniform(-1, 1)}, moved_anchor = anchor;
    const Vector2d center{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
    const RayPattern one = RayPattern::on_lattice(center, radius, anchor);
    EXPECT_GE(one.size, 45U);
    EXPECT_LT(one.size, RayPattern::kMost);  // so that none has been left out
    EXPECT_LT((anchor - center).norm(), 0.3 * radius);
    const Vector2d way = 0.05 * radius * Vector2d{random.uniform(-1, 1), random.uniform(-1, 1)};
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

// Sixteen rays about a place aside, by the measure in which the ellipse is a disc: within a quarter of its
// radius, all around and apart from each other, and none outside of the ellipse.
TEST(RayPattern, HasMoreRaysAboutWhatIsLowest) {
  Eigen::Matrix2d shape;
  shape << 0.03, 0.0, 0.01, 0.02;
  for (const Vector2d& middle : {Vector2d(0.5, -0.3), Vector2d(-0.2, 0.1), Vector2d(0.9, 0.3)}) {
    const RayPattern pattern = RayPattern::over_ellipse(shape, shape * middle);
    ASSERT_EQ(pattern.around_size, RayPattern::kAround);
    const bool inside = middle.norm() < 0.7;
    std::vector<Vector2d> places;
    Vector2d mean = Vector2d::Zero();
    for (const Eigen::Vector2f& around : pattern.around) {
      places.emplace_back(shape.inverse() * around.cast<double>());
      EXPECT_LE(places.back().norm(), 0.99 + 1e-6);
      EXPECT_LE((places.back() - middle).norm(), 0.25 + 1e-6);
      mean += places.back() / RayPattern::kAround;
    }
    EXPECT_LE((shape.inverse() * pattern.aim).norm(), 0.99 + 1e-9);
    if (!inside) continue;
    EXPECT_NEAR((shape.inverse() * pattern.aim - middle).norm(), 0.0, 1e-12);
    EXPECT_LT((mean - middle).norm(), 0.02);
    for (std::size_t i = 0; i < places.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) EXPECT_GT((places[i] - places[k]).norm(), 0.06);
  }
  EXPECT_EQ(RayPattern::over_ellipse(shape, shape * Vector2d(0.05, 0.05)).around_size, 0U);
}

TEST(SplatTracker, KnowsAllThatTheSolidTouchesWhereverItGoes) {
  Random random(43);
  std::vector<test::Splat> splats;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d at{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
    splats.push_back(test::splat(at, {random.uniform(0.0, 0.01), random.uniform(0.0, 0.002), 0.001}));
  }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  SplatTracker tracker(index);
  ContactSet touched;
  Vector3d at = Vector3d::Zero();
  for (int step = 0; step < 300; ++step) {
    at += 0.003 * Vector3d{random.normal(), random.normal(), random.normal()};
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

TEST(SelectSplats, LeavesOutNothingThatReachesIntoTheSolid) {
  Random random(44);
  std::vector<test::Splat> splats;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d at{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
    splats.push_back(test::splat(at, {random.uniform(0.0, 0.01), random.uniform(0.0, 0.002), 0.0005}));
  }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  SplatTracker all(index);
  const LocalSplats& near = all.around(ball(Vector3d::Zero(), 0.08));
  LocalSplats chosen, few(8);
  std::size_t most = 0;
  for (int step = 0; step < 50; ++step) {
    const Vector3d at = 0.03 * Vector3d{random.normal(), random.normal(), random.normal()};
    if (at.norm() > 0.06) continue;
    const Ellipsoid solid = ball(at, 0.015);
    ASSERT_TRUE(select_splats(near, solid, chosen));
    EXPECT_LT(chosen.size, near.size / 2);
    most = std::max(most, chosen.size);
    ContactSet touched;
    index.query(solid, touched);
    for (const Contact& contact : touched.contacts) {
      const std::span<const std::uint32_t> ids(chosen.id.data(), chosen.size);
      const auto found = std::ranges::find(ids, contact.id);
      ASSERT_NE(found, ids.end());
      const auto i = static_cast<std::size_t>(found - ids.begin());
      EXPECT_LT((chosen.position(i) - contact.center).norm(), 1e-7);
    }
    EXPECT_EQ(select_splats(near, solid, few), chosen.size <= 8);
    EXPECT_EQ(few.size, chosen.size <= 8 ? chosen.size : 0);
  }
  EXPECT_GT(most, 8U);
}

/// What a ray through the middle of a ball at the origin sees, looking down.
struct MiddleRay {
  explicit MiddleRay(const std::vector<test::Splat>& splats)
      : index(test::scene_of(splats), SceneFilter{}, Similarity{}), tracker(index) {}

  /// From a ball whose centre is at the height `z`; \returns the height of what is seen.
  double render(double z, RayLight& light) {
    const Vector3d center(0, 0, z);
    const Ellipsoid solid = ball(center, kRadius), larger = ball(center, kRadius + kReach);
    const ViewFrame view = ViewFrame::along(-Vector3d::UnitZ(), center, Vector3d::UnitX());
    const RayPattern pattern = RayPattern::over_ellipse(kRadius * Eigen::Matrix2d::Identity(), {0, 0});
    image->render(tracker.around(larger), view, Profile(solid, view), larger, pattern, 0.0, light);
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
    EXPECT_NEAR(ray.render(0.0, light), -0.03, 1e-6);
  });
}

// Veils of opacity 0.17 let 0.83, 0.69, 0.57 and then 0.47 of the light through: the fourth is seen, for a
// ball that has come through the ones before as for one that looks at all of them.
TEST_F(DepthViewTest, WhatTheToolHasComeThroughTakesLightAway) {
  std::vector<test::Splat> veils;
  for (int k = 0; k < 6; ++k)
    veils.push_back(test::splat({0, 0, -0.005 * k}, {0.5, 0.5, 1e-6}, Eigen::Quaterniond::Identity(), 0.17));
  on_every_target([&] {
    MiddleRay ray(veils);
    RayLight light;
    EXPECT_NEAR(ray.render(0.002, light), -0.015, 1e-6);
    EXPECT_NEAR(light.left[0], 1.0, 1e-6);
    // 9 mm lower, two veils are above the ball's centre, where it looks from.
    light.since -= 0.009;
    EXPECT_NEAR(ray.render(-0.007, light), -0.015, 1e-6);
    EXPECT_NEAR(light.left[0], 0.83 * 0.83, 1e-3);
    RayLight fresh;
    EXPECT_NEAR(ray.render(-0.007, fresh), -0.025, 1e-6)
        << "for one that starts there, the fourth from there";
    // Nothing is felt twice: what has taken more than it takes to be seen is as what has taken that.
    light.since -= 0.011;
    EXPECT_NEAR(ray.render(-0.018, light), -0.020, 1e-6);
    EXPECT_EQ(light.left[0], DepthView::kSeen);
  });
}

// What hides less than 1/255 = 0.0039 is not drawn, however many lie over each other: 250 of 0.99 exp(-3.31^2
// / 2) = 0.0041 leave 0.36, and of 0.99 exp(-3.34^2 / 2) = 0.0037 they would leave 0.39.
TEST(SeenSurface, EndsWhereAGaussianIsDrawnNoFarther) {
  std::vector<test::Splat> stack;
  for (int k = 0; k < 250; ++k)
    stack.push_back(
        test::splat({0, 0, 0.1 + 1e-4 * k}, {0.01, 0.01, 1e-6}, Eigen::Quaterniond::Identity(), 0.99));
  const SeenSurface seen(test::scene_of(stack), Similarity{});
  EXPECT_TRUE(seen.depth({0.0331, 0, 0}, Vector3d::UnitZ()).has_value());
  EXPECT_FALSE(seen.depth({0.0334, 0, 0}, Vector3d::UnitZ()).has_value());
}

// Infinitely thin and turned by 45 degrees about y: as much nearer or farther as aside.
TEST(SeenSurface, OfADiscAslantIsTheDisc) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::atan(1.0), Vector3d::UnitY()));
  for (const double size : {1e-4, 0.02}) {
    const SeenSurface seen(test::scene_of({test::splat({0, 0, 0.1}, {size, size, 0.0}, turn)}), Similarity{});
    for (const double x : {-0.5, 0.0, 0.25})
      EXPECT_NEAR(seen.depth({x * size, 0, 0}, Vector3d::UnitZ()).value(), 0.1 - x * size, 1e-4 * size);
  }
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
  const Tool ball(Vector3d::Constant(0.05));
  constexpr int kManyRings = 18;
  EXPECT_NEAR(SeenRays(beside, {0, 0, 0}, Vector3d::UnitZ(), ball.radius())
                  .first_touch(ball, {0, 0, 0}, kManyRings)
                  .value(),
              0.16, 0.003);
}

}  // namespace
}  // namespace palpate
