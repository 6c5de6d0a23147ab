// Where trials push: on the surface, from all sides alike, and where the tool has room.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/geometry/solids.h>
#include <palpate/study/evaluation_hand.h>
#include <palpate/study/trial_place.h>
#include <palpate/study/trial_tools.h>
#include <palpate/study/trials.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// Two balls of 10 mm, 30 mm from the handle: of a radius of 40 mm.
Tool dumbbell() {
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  return Tool({{"left", Vector3d::Constant(0.01), {{-0.03, 0, 0}, straight}},
               {"right", Vector3d::Constant(0.01), {{0.03, 0, 0}, straight}}});
}

// All directions within the angle alike: none is likelier round the axis, and the cosine is even between that
// of the angle and 1.
TEST(TrialPlace, AimsEvenlyWithinACone) {
  constexpr int kAims = 5000;
  for (const char* name : {"face", "edge", "corner", "hole", "plate"}) {
    const std::string kind = name;
    const bool sharp = kind == "edge" || kind == "corner";
    const double least = std::cos((sharp ? 45.0 : 20.0) * pi / 180.0);
    const TrialPlace place(kind, *trial_tool("ball10"), 0);
    Random random(3);
    Vector3d aside = Vector3d::Zero();
    double cosines = 0.0;
    for (int i = 0; i < kAims; ++i) {
      const TrialAim aim = place.aim(random, false);
      ASSERT_NEAR(aim.normal.norm(), 1.0, 1e-12) << name;
      ASSERT_NEAR(aim.along.norm(), 1.0, 1e-12) << name;
      const double cosine = -aim.along.dot(aim.normal);
      ASSERT_GE(cosine, least - 1e-12) << name;
      cosines += cosine / kAims;
      aside += (aim.along + cosine * aim.normal).normalized() / kAims;
    }
    EXPECT_LT(aside.norm(), 4.0 / std::sqrt(kAims)) << name;  // of one, a standard deviation of 1
    EXPECT_NEAR(cosines, 0.5 * (1.0 + least), 4.0 * (1.0 - least) / std::sqrt(12.0 * kAims)) << name;
  }
}

// Wherever the handle is pushed at, the tool is above the face with all of it.
TEST(TrialPlace, AimsAtAFaceWhereTheToolHasRoom) {
  for (const std::string_view name : trial_tools()) {
    const Tool tool = *trial_tool(name);
    const TrialPlace place("face", tool, 0);
    Random random(4);
    double widest = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vector3d at = place.aim(random, false).point;
      ASSERT_EQ(at.z(), place.top());
      widest = std::max(widest, std::abs(at.x()));
      for (const double side : {-1.0, 1.0})
        for (Eigen::Index k = 0; k < 2; ++k)
          ASSERT_NEAR(place.surface().distance(at + side * (tool.radius() + 0.004) * Vector3d::Unit(k)), 0.0,
                      1e-12)
              << name;
    }
    EXPECT_GT(widest, 0.02) << name;
  }
}

// A needle that is pushed tip first is within 10 degrees of its way.
TEST(TrialPlace, HoldsAToolTipFirst) {
  const TrialPlace place("face", *trial_tool("needle"), 0);
  Random random(5);
  double widest = 0.0;
  for (int i = 0; i < 500; ++i) {
    const TrialAim aim = place.aim(random, true);
    const Vector3d tip = aim.tool.parts()[0].pose.orientation * Vector3d::UnitZ();
    widest = std::max(widest, std::acos(std::min(1.0, tip.dot(aim.along))) * 180.0 / pi);
  }
  EXPECT_LE(widest, 10.0 + 1e-6);
  EXPECT_GT(widest, 9.0);
}

// Held at random, no direction of its axis is likelier than another.
TEST(TrialPlace, TurnsAToolInAllWaysAlike) {
  constexpr int kAims = 4000;
  const TrialPlace place("face", *trial_tool("needle"), 0);
  Random random(6);
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kAims; ++i)
    mean += place.aim(random, false).tool.parts()[0].pose.orientation.toRotationMatrix() / kAims;
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 4.0 / std::sqrt(3.0 * kAims));
}

// One of the tool's thinnest semi-axes or two.
TEST(TrialPlace, APlateIsAsThickAsTheToolOrTwice) {
  const Tool disc = *trial_tool("disc");
  for (const std::size_t variant : {0U, 1U, 2U}) {
    const double thickness = variant == 1 ? 0.010 : 0.005;
    const TrialPlace plate("plate", disc, variant);
    EXPECT_DOUBLE_EQ(*plate.thickness(), thickness);
    EXPECT_NEAR(plate.surface().distance(Vector3d::Zero()), -0.5 * thickness, 1e-12);
    EXPECT_NEAR(plate.top(), 0.5 * thickness, 1e-12);
  }
  EXPECT_EQ(*TrialPlace("sheet", disc, 0).thickness(), 0.0);
  EXPECT_FALSE(TrialPlace("face", disc, 0).thickness());
}

// 60 mm below a sheet, with the tool beside that, it is still the sheet's face that is nearest, and no
// border.
TEST(TrialPlace, ASheetIsSoWideThatNoBorderIsNearer) {
  for (const char* name : {"ball2", "plate"}) {
    const Tool tool = *trial_tool(name);
    const TrialPlace sheet("sheet", tool, 0);
    Random random(7);
    for (int i = 0; i < 200; ++i) {
      const TrialAim aim = sheet.aim(random, false);
      const Vector3d below = aim.point + kDeepestTrial / -aim.along.z() * aim.along;
      for (const double side : {-1.0, 1.0})
        for (Eigen::Index k = 0; k < 2; ++k)
          ASSERT_NEAR(
              sheet.surface().distance(below + side * (tool.radius() + kDeepestTrial) * Vector3d::Unit(k)),
              kDeepestTrial, 1e-12)
              << name;
    }
  }
}

// 300 x 200 x 160 mm have 0.28 m^2. At 0.5 mm that would be a million Gaussians: of 150,000 the box has sides
// of sqrt(0.15 / 1.12) of these. For a tool of 100 mm it is so large that 10 mm are left beside that.
TEST(TrialPlace, ABoxIsAsLargeAsItsGaussiansAndItsToolAllow) {
  EXPECT_NEAR(TrialPlace("face", *trial_tool("ball5"), 0).top(), 0.08, 1e-12);
  const TrialPlace fine("face", Tool(Vector3d::Constant(0.0012)), 0);
  EXPECT_EQ(fine.spacing(), 0.0005);
  EXPECT_NEAR(fine.top(), 0.08 * std::sqrt(0.15 / 1.12), 1e-9);
  const TrialPlace wide("face", *trial_tool("plate"), 0);
  EXPECT_NEAR(wide.top(), 0.08 * 1.1, 1e-12);
}

// Of what is about as thick as wide, its middle semi-axis, and half the radius of what has many parts: 15 %
// more or less.
TEST(TrialPlace, AHoleIsWiderThanTheToolOrNarrower) {
  struct {
    Tool tool;
    double half;
  } const cases[] = {{*trial_tool("ball20"), 0.02},
                     {*trial_tool("rod"), 0.003},
                     {*trial_tool("disc"), 0.03},
                     {dumbbell(), 0.02}};
  for (const auto& [tool, half] : cases) {
    EXPECT_NEAR(TrialPlace("hole", tool, 0).surface().distance(Vector3d::Zero()), 1.15 * half, 1e-9);
    EXPECT_NEAR(TrialPlace("hole", tool, 1).surface().distance(Vector3d::Zero()), 0.85 * half, 1e-9);
  }
}

// Within 3 mm, or the tool's thinnest semi-axis if that is less, of the middle of an edge, of a corner, and
// of the rim of a hole all around.
TEST(TrialPlace, AimsNearAnEdge) {
  for (const char* tool : {"ball10", "ball2"}) {
    const double near = std::min(0.003, trial_tool(tool)->thinnest());
    for (const char* name : {"edge", "corner", "hole"}) {
      const TrialPlace place(name, *trial_tool(tool), 0);
      Random random(8);
      Vector3d mean = Vector3d::Zero();
      constexpr int kAims = 1000;
      for (int i = 0; i < kAims; ++i) {
        const TrialAim aim = place.aim(random, false);
        EXPECT_LE(std::abs(place.surface().distance(aim.point)), near + 1e-12) << name;
        mean += aim.point / kAims;
      }
      if (std::string(name) == "hole") {
        EXPECT_LT(mean.norm(), 0.1 * place.surface().distance(Vector3d::Zero()));
      }
    }
  }
}

// Against every point of the tool: of a torus, whose surface bends under it both ways.
TEST(Deepest, IsThatOfTheLowestPointOnACurvedSurface) {
  const TrialPlace ring("hole", *trial_tool("ball10"), 0);
  constexpr int kPoints = 20000;
  for (const char* name : {"ball20", "disc"}) {
    const Tool tool = *trial_tool(name);
    Random random(9);
    for (int i = 0; i < 20; ++i) {
      const TrialAim aim = ring.aim(random, false);
      const Pose pose{aim.point - (tool.radius() + 0.005) * aim.along, Eigen::Quaterniond::Identity()};
      const Ellipsoid solid = aim.tool.parts()[0].at(pose);
      double most = -1.0;
      for (int k = 0; k < kPoints; ++k)
        most =
            std::max(most, -ring.surface().distance(solid.center + solid.axes * even_direction(k, kPoints)));
      EXPECT_NEAR(deepest(ring.surface(), aim.tool, pose), most, 4e-5) << name;
    }
  }
}

TEST(EvenDirection, IsSpreadEvenly) {
  constexpr int kCount = 500;
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (int k = 0; k < kCount; ++k) {
    const Vector3d u = even_direction(k, kCount);
    EXPECT_NEAR(u.norm(), 1.0, 1e-12);
    EXPECT_NEAR(u.z(), -even_direction(kCount - 1 - k, kCount).z(), 1e-12);
    sum += u;
    squares += u * u.transpose();
  }
  EXPECT_LT(sum.norm(), 0.01 * kCount);
  EXPECT_LT((squares / kCount - Eigen::Matrix3d::Identity() / 3.0).norm(), 0.01);
}

// A disc has 2 pi a^2 (1 + (1 - e^2) / e artanh e), a rod 2 pi b^2 (1 + a / (b e) arcsin e): half of that
// looks along, and two points are on each square of the spacing.
TEST(FrontOf, HasPointsAllOverTheSideThatLooksAlong) {
  const double flat = std::sqrt(1.0 - 25.0 / 900.0), slim = std::sqrt(1.0 - 9.0 / 10000.0);
  const double disc = 2.0 * pi * 9e-4 * (1.0 + (1.0 - flat * flat) / flat * std::atanh(flat));
  const double rod = 2.0 * pi * 9e-6 * (1.0 + 100.0 / (3.0 * slim) * std::asin(slim));
  struct {
    const char* name;
    double spacing, expected;
  } const cases[] = {{"ball10", 0.001, 4.0 * pi * 100.0},
                     {"disc", 0.002, disc / 4e-6},
                     {"rod", 0.001, rod / 1e-6},
                     {"ball2", 0.006, 100.0},
                     {"plate", 0.001, 6000.0}};
  const Vector3d along = Vector3d(1.0, -2.0, 0.5).normalized();
  for (const auto& [name, spacing, expected] : cases) {
    const Tool tool = turned(*trial_tool(name), Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5));
    const Ellipsoid solid = tool.parts()[0].at({});
    const Eigen::Matrix3d inverse = solid.axes.inverse();
    const std::vector<Vector3d> points = front_of(tool, along, spacing);
    EXPECT_NEAR(static_cast<double>(points.size()), expected, 0.02 * expected) << name;
    for (const Vector3d& point : points) {
      ASSERT_NEAR((inverse * point).norm(), 1.0, 1e-9) << name;
      ASSERT_GT((inverse.transpose() * inverse * point).dot(along), 0.0) << name;
    }
  }
  EXPECT_EQ(front_of(dumbbell(), along, 0.001).size(), 2 * front_of(ball(0.01), along, 0.001).size());
}

}  // namespace
}  // namespace palpate
