// Motions held back by planes, against solutions worked out by hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/constrained_motion.h>
#include <support/random_pairs.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kGyration = 0.02;

/// Of a body whose handle is the origin.
MotionConstraint plane(const Vector3d& normal, double gap, const Vector3d& point = Vector3d::Zero()) {
  return {normal.normalized(), point, gap};
}

double gap_after(const MotionConstraint& plane, const Motion& motion) {
  return plane.gap + plane.normal.dot(plane.of(motion));
}

TEST(ConstrainedMotion, IsTheWantedOneWhereNothingIsInTheWay) {
  const Motion wanted{{1, 2, 3}, {0.1, 0.2, 0.3}};
  std::array planes{plane({0, 0, 1}, 0.5), plane({1, 0, 0}, 0.0)};
  const Motion found = constrained_motion(wanted, planes, kGyration);
  EXPECT_EQ(found.translation, wanted.translation);
  EXPECT_EQ(found.rotation, wanted.rotation);
  for (const MotionConstraint& p : planes) EXPECT_EQ(p.push, 0.0);
}

TEST(ConstrainedMotion, EndsOnAPlane) {
  std::array planes{plane({0, 0, 1}, 0.25)};
  const Motion found = constrained_motion({{1, 2, -3}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR((found.translation - Vector3d(1, 2, -0.25)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(planes[0].push, 2.75, 1e-15);
}

TEST(ConstrainedMotion, EndsInTheCornerOfThreePlanes) {
  std::array planes{plane({1, 0, 0}, 0.1), plane({0, 1, 0}, 0.2), plane({0, 0, 1}, 0.3)};
  const Motion found = constrained_motion({{-1, -1, -1}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR((found.translation - Vector3d(-0.1, -0.2, -0.3)).norm(), 0.0, 1e-12);
}

// A rod along x with its handle at the origin, pushed down by 1 where a plane holds its end at x = g. Of the
// motions (z, turn about -y) with z + g turn >= 0, the one nearest to (-1, 0) by z^2 + g^2 turn^2 is half and
// half: z = -1/2, g turn = 1/2.
TEST(ConstrainedMotion, TurnsAboutWhatHoldsItAside) {
  std::array planes{plane({0, 0, 1}, 0.0, {kGyration, 0, 0})};
  const Motion found = constrained_motion({{0, 0, -1}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR((found.translation - Vector3d(0, 0, -0.5)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((kGyration * found.rotation - Vector3d(0, -0.5, 0)).norm(), 0.0, 1e-15);
}

/// As plane(), at the handle.
MotionConstraint rough(const Vector3d& normal, double friction) {
  MotionConstraint p = plane(normal, 0.0);
  p.friction = friction;
  return p;
}

// Pressed on by 3 and drawn along by 2: the friction of 0.5 holds 1.5 of it.
TEST(ConstrainedMotion, IsHeldBackByFriction) {
  std::array planes{rough({0, 0, 1}, 0.5)};
  const Motion found = constrained_motion({{2, 0, -3}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR((found.translation - Vector3d(0.5, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((planes[0].drag - Vector3d(-1.5, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(ConstrainedMotion, SticksWithinTheCone) {
  std::array planes{rough({0, 0, 1}, 0.7)};
  const Motion found = constrained_motion({{1, 1.5, -3}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR(found.translation.norm(), 0.0, 1e-12);
}

// A rod that is held by friction at the end of its arm, across it: it turns about that point. Of the motions
// (y, turn about z) with y + g turn = 0 the one nearest to (1, 0) is y = 1/2, g turn = -1/2.
TEST(ConstrainedMotion, TurnsAboutWhereItSticks) {
  MotionConstraint p = plane({0, 0, 1}, 0.0, {kGyration, 0, 0});
  p.friction = 100.0;
  std::array planes{p};
  const Motion found = constrained_motion({{0, 1, -1}, {0, 0, 0}}, planes, kGyration);
  EXPECT_NEAR(found.translation.y(), 0.5, 1e-6);
  EXPECT_NEAR(kGyration * found.rotation.z(), -0.5, 1e-6);
  EXPECT_NEAR(planes[0].of(found).norm(), 0.0, 1e-6);
}

// Coulomb: no more drag than friction times push; where there is less, the point does not slip, and where it
// slips, it is dragged against its way.
TEST(ConstrainedMotion, FulfilsCoulombsLaw) {
  test::Random random(912);
  int sticks = 0, slips = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d normal = random.direction();
    MotionConstraint p = plane(normal, 0.0, random.vector(0.0, 0.03));
    p.friction = random.uniform(0.1, 2.0);
    std::array planes{p};
    const Motion wanted{-0.01 * p.normal + 0.01 * random.direction(), 0.3 * random.direction()};
    const Motion found = constrained_motion(wanted, planes, kGyration);
    const double most = p.friction * planes[0].push, drag = planes[0].drag.norm();
    const Vector3d way = planes[0].of(found), slip = way - way.dot(p.normal) * p.normal;
    ASSERT_LE(drag, most + 1e-12);
    ASSERT_GE(way.dot(p.normal), -1e-6);
    if (drag < most - 1e-5) {
      ASSERT_LE(slip.norm(), 1e-6);
      ++sticks;
    } else if (most > 1e-5 && slip.norm() > 1e-5) {
      ASSERT_LT(slip.dot(planes[0].drag), 0.0);
      ++slips;
    }
  }
  EXPECT_GT(sticks, 200);
  EXPECT_GT(slips, 200);
}

// Karush, Kuhn and Tucker: out of all planes (as far as they do not give way), pushed by those it touches
// alone, and what is missing of the wanted motion is what they push.
TEST(ConstrainedMotion, FulfilsTheConditionsOfAnOptimum) {
  test::Random random(911);
  int held = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d up = random.direction();
    std::array<MotionConstraint, 3> planes;
    for (MotionConstraint& p : planes) {
      const Vector3d normal = up + 0.8 * random.direction();
      const double gap = random.uniform(0.0, 0.01);
      p = plane(normal, gap, random.vector(0.0, 0.03));
    }
    const Motion wanted{-0.02 * up + 0.01 * random.direction(), 0.5 * random.direction()};
    const Motion found = constrained_motion(wanted, planes, kGyration);
    Motion pushed = wanted;
    for (const MotionConstraint& p : planes) {
      held += p.push > 0.0 ? 1 : 0;
      ASSERT_GE(p.push, 0.0);
      const double left = gap_after(p, found);
      ASSERT_GE(left, -1e-5);
      ASSERT_LE(std::min(left, p.push), 2e-5);  // a sixteenth of a hair, and of what a device resolves
      pushed.translation += p.push * p.normal;
      pushed.rotation += p.push / (kGyration * kGyration) * p.arm.cross(p.normal);
    }
    ASSERT_NEAR((found.translation - pushed.translation).norm(), 0.0, 1e-12);
    ASSERT_NEAR((found.rotation - pushed.rotation).norm(), 0.0, 1e-10);
  }
  EXPECT_GT(held, 500);
}

/// Projected Gauss-Seidel as it is written down: every plane in every sweep.
Motion by_all_planes(const Motion& wanted, std::span<const MotionConstraint> planes, double gyration) {
  Motion motion = wanted;
  std::vector<double> push(planes.size(), 0.0);
  for (int sweep = 0; sweep < 128; ++sweep) {
    double change = 0.0;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const MotionConstraint& p = planes[k];
      const Vector3d lever = p.arm.cross(p.normal);
      const double missing = -(p.gap + p.normal.dot(p.of(motion)));
      const double step = std::max(-push[k], missing / (1.0 + lever.squaredNorm() / (gyration * gyration)));
      push[k] += step;
      motion.translation += step * p.normal;
      motion.rotation += step / (gyration * gyration) * lever;
      change = std::max(change, std::abs(step));
    }
    if (change < 1e-8) break;
  }
  return motion;
}

// Planes that are out of reach are left alone, and nothing comes of that.
TEST(ConstrainedMotion, IsThatOfAllPlanesInEverySweep) {
  test::Random random(913);
  for (int i = 0; i < 300; ++i) {
    const Vector3d up = random.direction();
    std::vector<MotionConstraint> planes;
    for (int k = 0; k < 200; ++k) {
      const Vector3d normal = up + 0.8 * random.direction();
      const double gap = random.uniform(0.0, 0.04);
      planes.push_back(plane(normal, gap, random.vector(0.0, 0.03)));
    }
    const Motion wanted{-0.02 * up + 0.01 * random.direction(), 0.5 * random.direction()};
    const Motion found = constrained_motion(wanted, planes, kGyration);
    const Motion same = by_all_planes(wanted, planes, kGyration);
    ASSERT_NEAR((found.translation - same.translation).norm(), 0.0, 1e-12);
    ASSERT_NEAR((found.rotation - same.rotation).norm(), 0.0, 1e-10);
  }
}

}  // namespace
}  // namespace palpate
