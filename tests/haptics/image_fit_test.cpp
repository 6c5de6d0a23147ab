// The far side of a tool and the quadric through what is seen below it, against solids and surfaces in closed
// form.

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/splat_tracker.h>
#include <palpate/geometry/solids.h>
#include <palpate/haptics/image_fit.h>
#include <support/random_pairs.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A solid that is turned any way, and a view along any direction from its centre.
struct Any {
  explicit Any(test::Random& random)
      : solid(any_solid(random)),
        view(ViewFrame::along(random.direction(), solid.center, Vector3d::UnitX())),
        profile(solid, view) {}

  /// Well inside of the silhouette.
  Vector2d place(test::Random& random) const {
    for (;;) {
      const Vector3d inside = solid.center + 0.8 * (solid.axes * random.vector(0.0, 1.0));
      Vector2d at = image_of(view, inside);
      if (is_below(profile, at)) return at;
    }
  }

  static Ellipsoid any_solid(test::Random& random) {
    const Pose pose{{0.3, -0.2, 0.1}, random.rotation()};
    return Ellipsoid::from_semi_axes(
        pose, {random.uniform(0.01, 0.03), random.uniform(0.01, 0.03), random.uniform(0.01, 0.03)});
  }

  /// Where the ray at `at` leaves the solid, and where it enters it: by the quadratic equation.
  std::pair<double, double> chord(const Vector2d& at) const {
    const Eigen::Matrix3d inverse = solid.axes.inverse();
    const Vector3d from = inverse * (view.at(at.x(), at.y(), 0.0) - solid.center), way = inverse * view.w;
    const double a = way.squaredNorm(), b = from.dot(way), c = from.squaredNorm() - 1.0;
    const double root = std::sqrt(b * b - a * c);
    return {(-b - root) / a, (-b + root) / a};
  }

  Ellipsoid solid;
  ViewFrame view;
  Profile profile;
};

TEST(Towards, GoesNoFartherThanItMay) {
  const Vector2d from(1.0, 2.0), to(4.0, 6.0);
  EXPECT_NEAR((towards(from, to, 2.5) - Vector2d(2.5, 4.0)).norm(), 0.0, 1e-15);
  EXPECT_EQ(towards(from, to, 5.0), to);
  EXPECT_EQ(towards(from, from, 1.0), from);
}

TEST(ImageOf, IsWhereTheViewHasThePoint) {
  const ViewFrame view = ViewFrame::along({0.0, 0.6, -0.8}, {0.1, 0.2, 0.3}, Vector3d::UnitX());
  EXPECT_NEAR((image_of(view, view.at(0.02, -0.03, 0.7)) - Vector2d(0.02, -0.03)).norm(), 0.0, 1e-15);
}

TEST(Rays, BeginAQuarterOfTheirWayThroughTheSolid) {
  test::Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    const Any any(random);
    const Vector2d at = any.place(random);
    const auto [in, out] = any.chord(at);
    EXPECT_NEAR(depth_of(any.profile, at), out, 1e-6);
    EXPECT_NEAR(start_of(any.profile, at), in + 0.25 * (out - in), 1e-6);
  }
}

TEST(Rays, TheFirstBeginsBeforeAllOthersAndNoSooner) {
  test::Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Any any(random);
    double first = 0.0;
    for (int i = -60; i <= 60; ++i)
      for (int k = -60; k <= 60; ++k) {
        const Vector2d at(5e-4 * i, 5e-4 * k);
        if (is_below(any.profile, at)) first = std::min(first, start_of(any.profile, at));
      }
    const double start = start_of_all(any.profile, any.solid, any.view.w);
    EXPECT_LT(start, first + 1e-6);
    EXPECT_NEAR(start, first, 4e-4);
  }
}

TEST(InwardNormal, IsAgainstTheGradientOfTheSolid) {
  test::Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Any any(random);
    const Vector3d normal = random.direction();
    // The point where the solid faces that way, by its support.
    EXPECT_NEAR((inward_normal(any.solid, farthest_point(any.solid, normal)) + normal).norm(), 0.0, 1e-9);
  }
}

TEST(ToolSide, HasSlopeAndCurvatureOfTheFarSide) {
  constexpr double kStep = 1e-5;
  test::Random random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Any any(random);
    const Vector2d at = any.place(random);
    const auto depth = [&](double x, double y) { return any.chord(at + Vector2d(x, y)).second; };
    const ToolSide side(any.profile, at);
    const Vector2d slope(depth(kStep, 0.0) - depth(-kStep, 0.0), depth(0.0, kStep) - depth(0.0, -kStep));
    EXPECT_NEAR((side.slope - slope / (2.0 * kStep)).norm(), 0.0, 1e-4 * (1.0 + side.slope.norm()));
    Matrix2d bend;
    bend(0, 0) = depth(kStep, 0.0) - 2.0 * depth(0.0, 0.0) + depth(-kStep, 0.0);
    bend(1, 1) = depth(0.0, kStep) - 2.0 * depth(0.0, 0.0) + depth(0.0, -kStep);
    bend(0, 1) = bend(1, 0) =
        0.25 * (depth(kStep, kStep) - depth(kStep, -kStep) - depth(-kStep, kStep) + depth(-kStep, -kStep));
    EXPECT_NEAR((side.curvature + bend / (kStep * kStep)).norm(), 0.0, 1e-3 * side.curvature.norm());
  }
}

// Of a solid that is curved by 50 and 100 / m: what of a surface is above 50.
TEST(ToolSide, TakesOfASurfaceWhatIsAboveTheLeastOfTheTool) {
  const Ellipsoid solid = Ellipsoid::from_semi_axes({}, {0.02, std::sqrt(0.0002), 0.02});
  const ToolSide side(Profile(solid, ViewFrame::along(-Vector3d::UnitZ(), {}, Vector3d::UnitX())), {0, 0});
  EXPECT_NEAR(side.curvature(0, 0), 50.0, 1e-3);
  EXPECT_NEAR(side.curvature(1, 1), 100.0, 1e-3);
  const double c = std::cos(0.4), s = std::sin(0.4);
  Matrix2d turn;
  turn << c, -s, s, c;
  const auto turned = [&](double a, double b) {
    return Matrix2d(turn * Vector2d(a, b).asDiagonal() * turn.transpose());
  };
  EXPECT_NEAR((side.more_than_tool(turned(80.0, 20.0)) - turned(30.0, 0.0)).norm(), 0.0, 1e-3);
  EXPECT_NEAR((side.more_than_tool(turned(-90.0, 60.0)) - turned(0.0, 10.0)).norm(), 0.0, 1e-3);
}

TEST(ToolSide, FindsWhereASurfaceIsNearest) {
  const Ellipsoid solid = Ellipsoid::from_semi_axes({}, Vector3d(0.03, 0.02, 0.02));
  const ToolSide side(Profile(solid, ViewFrame::along(-Vector3d::UnitZ(), {}, Vector3d::UnitX())), {0, 0});
  Matrix2d bend;
  bend << 30.0, 5.0, 5.0, 10.0;
  const Vector2d slope(0.1, -0.05), at = side.to_least(slope, bend);
  // The gap between them: slope . u + u . (curvature + bend) u / 2, about which the least is a stationary
  // point.
  const auto gap = [&](const Vector2d& u) {
    return (slope - side.slope).dot(u) + 0.5 * u.dot((side.curvature + bend) * u);
  };
  for (int k = 0; k < 8; ++k) {
    const Vector2d aside =
        1e-4 * Vector2d(std::cos(0.25 * std::numbers::pi * k), std::sin(0.25 * std::numbers::pi * k));
    EXPECT_GT(gap(at + aside), gap(at));
    EXPECT_LT(gap(at + aside) - gap(at), 1e-4 * 1e-4 * 100.0);
  }
}

/// What a ball at the origin sees of a surface z = -height(x, y), of small discs along it, looking down.
class Seen {
 public:
  template <class Height>
  explicit Seen(const Height& height) : Seen(discs(height)) {}

  explicit Seen(const std::vector<test::Splat>& splats)
      : index_(test::scene_of(splats), SceneFilter{}, Similarity{}) {
    SplatTracker tracker(index_);
    Vector2d anchor = kCenter;
    RayLight light;
    image_->render(tracker.around(larger_), view_, Profile(solid_, view_), larger_,
                   RayPattern::on_lattice(kCenter, kRadius * kDetail, anchor), 0.0, light);
  }

  bool fit(ImageFit& fit, double level) const {
    return fit.to(*image_, {kCenter, kDetail, level, static_cast<float>(kRadius)});
  }

  static constexpr double kDetail = 0.008, kRadius = 2.0;
  static inline const Vector2d kCenter{0.004, -0.003};

 private:
  template <class Height>
  static std::vector<test::Splat> discs(const Height& height) {
    constexpr double kSpacing = 0.001;
    std::vector<test::Splat> splats;
    for (int i = -35; i <= 35; ++i)
      for (int k = -35; k <= 35; ++k) {
        const double x = kSpacing * i, y = kSpacing * k;
        constexpr double kStep = 1e-6;
        const Vector3d normal(height(x + kStep, y) - height(x - kStep, y),
                              height(x, y + kStep) - height(x, y - kStep), 2.0 * kStep);
        // The view looks along -z with u = x, so that v = -y.
        splats.push_back(test::splat({x, -y, -height(x, y)}, {0.8 * kSpacing, 0.8 * kSpacing, 1e-6},
                                     Eigen::Quaterniond::FromTwoVectors(
                                         Vector3d::UnitZ(), Vector3d(normal.x(), -normal.y(), normal.z())),
                                     0.95));
      }
    return splats;
  }

  SceneIndex index_;
  Ellipsoid solid_ = Ellipsoid::from_semi_axes({}, Vector3d::Constant(0.02)),
            larger_ = Ellipsoid::from_semi_axes({}, Vector3d::Constant(0.05));
  ViewFrame view_ = ViewFrame::along(-Vector3d::UnitZ(), Vector3d::Zero(), Vector3d::UnitX());
  std::unique_ptr<DepthView> image_ = std::make_unique<DepthView>();
};

TEST(ImageFit, OfASlopeIsTheSlopeWhereverItIsCountedFrom) {
  const auto height = [](double x, double y) { return 0.03 + 0.2 * x - 0.1 * y; };
  const Seen seen(height);
  for (const double level : {0.0, 0.03}) {
    ImageFit fit;
    ASSERT_TRUE(seen.fit(fit, level));
    for (const Vector2d& at : {Vector2d(0.0, 0.0), Seen::kCenter, Vector2d(0.012, 0.006)})
      EXPECT_NEAR(fit.depth(at), height(at.x(), at.y()), 3e-4) << level;
    EXPECT_NEAR((fit.slope() - Vector2d(0.2, -0.1)).norm(), 0.0, 0.01);
    EXPECT_LT(fit.bend().norm(), 2.0);
    EXPECT_LT(fit.roughness(), 3e-4);
    EXPECT_NEAR(fit.moments().covered(), 1.0, 0.1);
  }
}

TEST(ImageFit, OfAQuadricHasItsBend) {
  const auto height = [](double x, double y) { return 0.03 + 4.0 * x * x + 1.0 * y * y + 2.0 * x * y; };
  const Seen seen(height);
  ImageFit fit;
  ASSERT_TRUE(seen.fit(fit, 0.03));
  Matrix2d bend;
  bend << 8.0, 2.0, 2.0, 2.0;
  EXPECT_NEAR((fit.bend() - bend).norm(), 0.0, 1.5);
  const Vector2d& c = Seen::kCenter;
  EXPECT_NEAR((fit.slope() - bend * c).norm(), 0.0, 0.01);
  for (const Vector2d& at : {c, Vector2d(0.01, -0.003), Vector2d(0.004, 0.005)})
    EXPECT_NEAR(fit.depth(at), height(at.x(), at.y()), 3e-4);
}

// Depth, slope and bend are of one quadric, by Taylor's formula.
TEST(ImageFit, IsTheQuadricOfItsSlopeAndBend) {
  const Seen seen(
      [](double x, double y) { return 0.03 + 0.1 * x + 4.0 * x * x - 3.0 * y * y + 5.0 * x * y; });
  ImageFit fit;
  ASSERT_TRUE(seen.fit(fit, 0.03));
  const Matrix2d bend = fit.bend();
  EXPECT_GT(bend(0, 0), 4.0);
  EXPECT_LT(bend(1, 1), -3.0);
  EXPECT_GT(bend(0, 1), 3.0);
  EXPECT_EQ(bend(0, 1), bend(1, 0));
  for (const Vector2d& d :
       {Vector2d(0.0, 0.0), Vector2d(0.01, 0.0), Vector2d(0.0, -0.01), Vector2d(0.008, 0.009)})
    EXPECT_NEAR(fit.depth(Seen::kCenter + d),
                fit.depth(Seen::kCenter) + fit.slope().dot(d) + 0.5 * d.dot(bend * d), 1e-12);
}

TEST(ImageFit, IsLittleMovedByWhatStandsOut) {
  // A tenth of the window is 8 mm nearer: a plain fit would be moved by as much as 0.8 mm.
  const auto height = [](double x, double) { return x > 0.012 ? 0.022 : 0.03; };
  const Seen seen(height);
  ImageFit fit;
  ASSERT_TRUE(seen.fit(fit, 0.03));
  EXPECT_NEAR(fit.depth(Seen::kCenter), 0.03, 3e-4);
}

TEST(ImageFit, SaysHowRoughItIs) {
  // Steps to either side of their mean, which discs that lie over each other make a little smaller.
  double last = 0.0;
  for (const double step : {0.0005, 0.001}) {
    const auto height = [step](double x, double y) {
      const double sign =
          std::sin(2.0 * std::numbers::pi * x / 0.008) * std::sin(2.0 * std::numbers::pi * y / 0.008);
      return 0.03 + (sign > 0.0 ? step : -step);
    };
    const Seen seen(height);
    ImageFit fit;
    ASSERT_TRUE(seen.fit(fit, 0.03));
    EXPECT_GT(fit.roughness(), 0.6 * step);
    EXPECT_LT(fit.roughness(), step);
    if (last > 0.0) {
      EXPECT_NEAR(fit.roughness(), 2.0 * last, 0.1 * last);
    }
    last = fit.roughness();
  }
}

TEST(ImageFit, IsNoneWhereNothingIsSeen) {
  const Seen seen([](double, double) { return 0.2; });
  ImageFit fit;
  EXPECT_FALSE(seen.fit(fit, 0.03));
}

// A speck that a single ray meets, whose light falls to 1 - h: of what it would lose of a wall, from 3/4 to
// 1/4, that is 2 (h - 1/4), and a thousandth of what all rays would have is needed.
TEST(ImageFit, IsNoneWhereNextToNothingIsSeen) {
  const auto speck = [](double opacity) {
    return std::vector{test::splat({Seen::kCenter.x(), -Seen::kCenter.y(), -0.03}, {5e-4, 5e-4, 1e-6},
                                   Eigen::Quaterniond::Identity(), opacity)};
  };
  for (const bool enough : {false, true}) {
    const Seen seen(speck(enough ? 0.27 : 0.2535));
    ImageFit fit;
    EXPECT_EQ(seen.fit(fit, 0.03), enough);
    const double share = 2.0 * ((enough ? 0.27 : 0.2535) - 0.25), covered = fit.moments().covered();
    EXPECT_NEAR(fit.moments().hit, share, 0.01 * share) << "of the ray in the middle, and no other";
    EXPECT_EQ(covered > 1e-3, enough);
    EXPECT_GT(covered, 2e-4);
    EXPECT_LT(covered, 5e-3);
  }
}

}  // namespace
}  // namespace palpate
