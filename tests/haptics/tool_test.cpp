// Tools of many ellipsoids: sizes and moments against their points, and queries against one query a part.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/tool.h>
#include <palpate/haptics/tool_query.h>
#include <support/random_scenes.h>
#include <support/random_tools.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = 1e-12;

Eigen::Quaterniond quarter_about(const Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, axis));
}

TEST(ToolPart, IsWhereThePosesOfToolAndPartTakeIt) {
  // In the tool frame the part's x is y, its y is -x. The tool turns y to z and z to -y.
  const ToolPart part{"part", {1, 2, 3}, {{1, 5, 0}, quarter_about(Vector3d::UnitZ())}};
  const Ellipsoid solid = part.at({{10, 0, 0}, quarter_about(Vector3d::UnitX())});
  EXPECT_LE((solid.center - Vector3d(11, 0, 5)).norm(), kRounding);
  EXPECT_LE((solid.axes.col(0) - Vector3d(0, 0, 1)).norm(), kRounding);
  EXPECT_LE((solid.axes.col(1) - Vector3d(-2, 0, 0)).norm(), kRounding);
  EXPECT_LE((solid.axes.col(2) - Vector3d(0, -3, 0)).norm(), kRounding);
}

TEST(Tool, OfThreeNumbersIsAnEllipsoidOnTheHandle) {
  const Tool tool({0.01, 0.03, 0.02});
  ASSERT_EQ(tool.parts().size(), 1U);
  const Ellipsoid solid = tool.parts()[0].at({});
  EXPECT_EQ(solid.center, Vector3d(0, 0, 0));
  EXPECT_EQ(solid.axes.diagonal(), Vector3d(0.01, 0.03, 0.02));
  EXPECT_EQ(Tool{}.parts()[0].semi_axes, Vector3d(0.02, 0.02, 0.04));
}

/// Points u of the unit sphere, the ends of its axes among them.
std::vector<Vector3d> sphere_points(test::Random& random, int count) {
  std::vector<Vector3d> points;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) points.emplace_back(sign * Vector3d::Unit(k));
  for (int i = 0; i < count; ++i) points.push_back(random.direction());
  return points;
}

TEST(Tool, SizesAreThoseOfItsSurface) {
  test::Random random(941);
  const std::vector<Vector3d> sphere = sphere_points(random, 20000);
  for (const int count : {1, 2, 5, 20}) {
    const Tool tool = test::random_tool(random, count, 0.05);
    const Vector3d n = random.direction();
    double nearest = 1e9, farthest = 0.0, outermost = 0.0, along = -1e9;
    for (const ToolPart& part : tool.parts()) {
      const Ellipsoid solid = part.at({});
      for (const Vector3d& u : sphere) {
        const Vector3d arm = solid.axes * u, point = solid.center + arm;
        nearest = std::min(nearest, arm.norm());
        farthest = std::max(farthest, arm.norm());
        outermost = std::max(outermost, point.norm());
        along = std::max(along, point.dot(n));
      }
    }
    EXPECT_NEAR(tool.thinnest(), nearest, kRounding);
    EXPECT_NEAR(tool.longest(), farthest, kRounding);
    EXPECT_GE(tool.radius(), outermost - kRounding);
    // 20000 points are some 0.025 apart; what lies between two of them stands out by half the square of that.
    EXPECT_GE(tool.support(n), along - kRounding);
    EXPECT_LE(tool.support(n), along + 1e-3 * tool.longest());
  }
}

TEST(Tool, RadiusReachesTheFarthestEnd) {
  const Tool tool({{"ball", {1, 1, 1}, {{0, 0, 2}, Eigen::Quaterniond::Identity()}},
                   {"needle", {4, 0.1, 0.1}, {{-3, 0, 0}, Eigen::Quaterniond::Identity()}}});
  EXPECT_NEAR(tool.radius(), 7.0, kRounding);
  EXPECT_NEAR(tool.support(Vector3d::UnitX()), 1.0, kRounding);
  EXPECT_NEAR(tool.support(-Vector3d::UnitX()), 7.0, kRounding);
  EXPECT_NEAR(tool.support(-Vector3d::UnitZ()), 0.1, kRounding);
}

TEST(Tool, GyrationIsThatOfTheTextbook) {
  // A ball: 2/5 r^2 about every axis.
  EXPECT_NEAR(Tool(Vector3d(3, 3, 3)).gyration(), 3.0 * std::sqrt(0.4), kRounding);
  // An ellipsoid: (b^2 + c^2) / 5 about the first axis and so on; for 1, 2, 3 the mean of 13, 10, 5 fifths.
  EXPECT_NEAR(Tool(Vector3d(1, 2, 3)).gyration(), std::sqrt(28.0 / 15.0), kRounding);
  // Two balls on a rod along x: 2/5 about x, 2/5 + 4 about y and z.
  const Tool dumbbell({{"left", {1, 1, 1}, {{-2, 0, 0}, Eigen::Quaterniond::Identity()}},
                       {"right", {1, 1, 1}, {{2, 0, 0}, Eigen::Quaterniond::Identity()}}});
  EXPECT_NEAR(dumbbell.gyration(), std::sqrt(46.0 / 15.0), kRounding);
}

TEST(Tool, GyrationIsThatOfItsPoints) {
  test::Random random(942);
  for (const int count : {1, 3, 12}) {
    const Tool tool = test::random_tool(random, count, 1.0);
    constexpr int kPoints = 100000;
    double volume = 0.0, moment = 0.0;
    for (const ToolPart& part : tool.parts()) {
      const Ellipsoid solid = part.at({});
      const double share = solid.axes.determinant() / kPoints;
      for (int i = 0; i < kPoints; ++i) {
        const double distance = std::cbrt(random.uniform(0.0, 1.0));
        const Vector3d u = distance * random.direction();
        const Vector3d x = solid.center + solid.axes * u;
        volume += share;
        moment += share * (x.squaredNorm() - x.x() * x.x() + x.squaredNorm() - x.y() * x.y() +
                           x.squaredNorm() - x.z() * x.z());
      }
    }
    EXPECT_NEAR(tool.gyration(), std::sqrt(moment / volume / 3.0), 0.01 * tool.gyration());
  }
}

/// Splats near the unit sphere.
SceneIndex some_index(test::Random& random) {
  return {test::scene_of(test::sphere_of_splats(random, 5000)), SceneFilter{}, Similarity{}};
}

void expect_same(const Contact& a, const Contact& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_NEAR(a.k_min, b.k_min, 1e-12);
  EXPECT_NEAR((a.point - b.point).norm(), 0.0, 1e-9);
  EXPECT_NEAR((a.normal - b.normal).norm(), 0.0, 1e-7);
}

TEST(ToolQuery, HasTheContactsOfEveryPart) {
  test::Random random(943);
  const SceneIndex index = some_index(random);
  ContactSet all, of_part;
  std::size_t seen = 0;
  for (int i = 0; i < 100; ++i) {
    const Tool tool = test::random_tool(random, 1 + i % 20, 0.1);
    const Pose pose{random.direction(), random.rotation()};
    query(index, tool, pose, all);
    std::size_t at = 0, candidates = 0, filtered = 0;
    for (std::uint32_t k = 0; k < tool.parts().size(); ++k) {
      index.query(tool.parts()[k].at(pose), of_part);
      candidates += of_part.candidates;
      filtered += of_part.filtered;
      ASSERT_LE(at + of_part.contacts.size(), all.contacts.size());
      for (const Contact& expected : of_part.contacts) {
        EXPECT_EQ(all.contacts[at].part, k);
        expect_same(all.contacts[at++], expected);
      }
    }
    EXPECT_EQ(at, all.contacts.size());
    EXPECT_EQ(all.candidates, candidates);
    EXPECT_EQ(all.filtered, filtered);
    seen += at;
  }
  EXPECT_GT(seen, 1000U);
}

TEST(ToolQuery, OfSoManyPairsFindsThoseThatComeFirst) {
  test::Random random(946);
  const SceneIndex index = some_index(random);
  const Tool tool = test::random_tool(random, 5, 1.5);
  const Pose pose{random.direction(), random.rotation()};
  ContactSet all, some;
  query(index, tool, pose, all);
  ASSERT_GT(all.contacts.size(), 1000U);
  query(index, tool, pose, all.filtered + 1000, some);
  EXPECT_TRUE(some.complete);
  EXPECT_EQ(some.contacts.size(), all.contacts.size());
  query(index, tool, pose, 1, some);
  EXPECT_FALSE(some.complete);
  ASSERT_LT(some.contacts.size(), all.contacts.size());
  for (std::size_t i = 0; i < some.contacts.size(); ++i) {
    EXPECT_EQ(some.contacts[i].part, all.contacts[i].part);
    expect_same(some.contacts[i], all.contacts[i]);
  }
}

TEST(ToolTracker, FindsWhatAFreshQueryDoes) {
  test::Random random(944);
  const SceneIndex index = some_index(random);
  const Tool tool = test::random_tool(random, 6, 0.1);
  ToolTracker tracker(index, tool);
  ContactSet tracked, fresh;
  Pose pose{{0, 0, 1.05}, random.rotation()};
  std::size_t seen = 0;
  for (int tick = 0; tick < 600; ++tick) {
    const bool leap = tick % 100 == 99;
    const Vector3d step = (leap ? 0.3 : 0.002) * random.direction();
    pose.position = random.uniform(0.95, 1.05) * (pose.position + step).normalized();
    pose.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.02, random.direction())) * pose.orientation;
    tracker.query(pose, tracked);
    query(index, tool, pose, fresh);
    ASSERT_EQ(tracked.contacts.size(), fresh.contacts.size()) << "tick " << tick;
    for (std::size_t i = 0; i < fresh.contacts.size(); ++i) {
      EXPECT_EQ(tracked.contacts[i].part, fresh.contacts[i].part);
      expect_same(tracked.contacts[i], fresh.contacts[i]);
    }
    seen += fresh.contacts.size();
  }
  EXPECT_GT(seen, 5000U);
}

// A bound on the pairs of all parts together: the parts that come first have all of theirs, the one that
// meets the bound has some, and those after it none.
TEST(ToolTracker, OfSoManyPairsFindsThoseThatComeFirst) {
  constexpr std::size_t kBuffer = 256;  // by as many it may be exceeded
  test::Random random(945);
  const SceneIndex index(test::scene_of(test::sphere_of_splats(random, 20000)), SceneFilter{}, Similarity{});
  std::vector<ToolPart> balls;
  for (const double y : {-0.3, 0.0, 0.3})
    balls.push_back({"ball", Vector3d::Constant(0.5), {{0, y, 0}, Eigen::Quaterniond::Identity()}});
  const Tool tool(balls);
  const Pose pose{{0.9, 0, 0}, Eigen::Quaterniond::Identity()};
  ToolTracker tracker(index, tool);
  ContactSet all, some;
  tracker.query(pose, all);
  ASSERT_TRUE(all.complete);
  std::vector<std::size_t> of_part(balls.size()), pairs;
  for (const Contact& contact : all.contacts) ++of_part[contact.part];
  for (const ToolPart& ball : balls) {
    ToolTracker(index, Tool(std::vector{ball})).query(pose, some);
    pairs.push_back(some.filtered);
    ASSERT_GT(some.contacts.size(), 4 * kBuffer);
  }
  std::size_t pairs_before = 0, contacts_before = 0;
  for (std::size_t last = 0; last < balls.size(); ++last) {
    const std::size_t most = pairs_before + pairs[last] / 2;
    tracker.query(pose, some, most);
    EXPECT_FALSE(some.complete) << last;
    EXPECT_GT(some.contacts.size(), contacts_before) << last;
    EXPECT_LE(some.contacts.size(), contacts_before + pairs[last] / 2 + kBuffer) << last;
    ASSERT_LT(some.contacts.size(), contacts_before + of_part[last]) << last;
    for (std::size_t i = 0; i < some.contacts.size(); ++i) {
      EXPECT_EQ(some.contacts[i].part, all.contacts[i].part) << last;
      EXPECT_EQ(some.contacts[i].id, all.contacts[i].id) << last;
    }
    pairs_before += pairs[last];
    contacts_before += of_part[last];
    if (last + 1 == balls.size()) continue;
    tracker.query(pose, some, pairs_before);
    EXPECT_FALSE(some.complete) << last;
    EXPECT_LE(some.contacts.size(), contacts_before) << "none of the next";
  }
  tracker.query(pose, some, 4 * all.filtered);
  EXPECT_TRUE(some.complete);
  EXPECT_EQ(some.contacts.size(), all.contacts.size());
}

}  // namespace
}  // namespace palpate
