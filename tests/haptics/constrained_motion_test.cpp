// Motions held back by planes, against solutions worked out by hand.

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <palpate/haptics/constrained_motion.h>
#include <support/random_pairs.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Random;

constexpr double kGyration = 0.02;

SurfacePatch plane(const Vector3d& normal, double gap, const Vector3d& foot = Vector3d::Zero()) {
  SurfacePatch patch;
  patch.normal = normal.normalized();
  patch.foot = foot;
  patch.gap = gap;
  return patch;
}

/// Of `patch` after `motion` of a body whose handle is the origin, to first order.
double gap_after(const SurfacePatch& patch, const Motion& motion) {
  return patch.gap + patch.normal.dot(motion.translation + motion.rotation.cross(patch.foot));
}

TEST(ConstrainedMotion, IsTheWantedOneWhereNothingIsInTheWay) {
  const Motion wanted{{1, 2, 3}, {0.1, 0.2, 0.3}};
  const std::array planes{plane({0, 0, 1}, 0.5), plane({1, 0, 0}, 0.0)};
  const ConstrainedMotion found = constrained_motion(wanted, planes, Vector3d::Zero(), kGyration);
  EXPECT_FALSE(found.held);
  EXPECT_EQ(found.motion.translation, wanted.translation);
  EXPECT_EQ(found.motion.rotation, wanted.rotation);
}

TEST(ConstrainedMotion, EndsOnAPlane) {
  const std::array planes{plane({0, 0, 1}, 0.25)};
  const auto found = constrained_motion({{1, 2, -3}, {0, 0, 0}}, planes, Vector3d::Zero(), kGyration);
  EXPECT_TRUE(found.held);
  EXPECT_NEAR((found.motion.translation - Vector3d(1, 2, -0.25)).norm(), 0.0, 1e-15);
}

TEST(ConstrainedMotion, EndsInTheCornerOfThreePlanes) {
  const std::array planes{plane({1, 0, 0}, 0.1), plane({0, 1, 0}, 0.2), plane({0, 0, 1}, 0.3)};
  const auto found = constrained_motion({{-1, -1, -1}, {0, 0, 0}}, planes, Vector3d::Zero(), kGyration);
  EXPECT_NEAR((found.motion.translation - Vector3d(-0.1, -0.2, -0.3)).norm(), 0.0, 1e-12);
}

// A rod along x with its handle at the origin, pushed down by 1 where a plane holds its end at x = g. Of the
// motions (z, turn about -y) with z + g turn >= 0, the one nearest to (-1, 0) by z^2 + g^2 turn^2 is half and
// half: z = -1/2, g turn = 1/2.
TEST(ConstrainedMotion, TurnsAboutWhatHoldsItAside) {
  const std::array planes{plane({0, 0, 1}, 0.0, {kGyration, 0, 0})};
  const auto found = constrained_motion({{0, 0, -1}, {0, 0, 0}}, planes, Vector3d::Zero(), kGyration);
  EXPECT_NEAR((found.motion.translation - Vector3d(0, 0, -0.5)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((kGyration * found.motion.rotation - Vector3d(0, -0.5, 0)).norm(), 0.0, 1e-15);
}

// Optimal if it keeps out of all planes, and what is missing of the wanted motion is a push along those it
// touches.
TEST(ConstrainedMotion, FulfilsTheConditionsOfAnOptimum) {
  Random random(911);
  int held = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d up = random.direction();
    std::array<SurfacePatch, 3> planes;
    for (SurfacePatch& p : planes) {
      p = plane(up + 0.8 * random.direction(), random.uniform(0.0, 0.01),
                random.uniform(0.0, 0.03) * random.direction());
    }
    const Motion wanted{-0.02 * up + 0.01 * random.direction(), 0.5 * random.direction()};
    const auto found = constrained_motion(wanted, planes, Vector3d::Zero(), kGyration);
    held += found.held ? 1 : 0;
    for (const SurfacePatch& p : planes) ASSERT_GE(gap_after(p, found.motion), -1e-5);
    // Any feasible motion makes an obtuse angle with what is missing: here towards standing still, which is
    // feasible.
    const Vector3d missing = found.motion.translation - wanted.translation,
                   missing_turn = kGyration * (found.motion.rotation - wanted.rotation);
    const double blocked =
        missing.dot(-found.motion.translation) + missing_turn.dot(-kGyration * found.motion.rotation);
    ASSERT_GE(blocked, -1e-7);
    ASSERT_LE(
        length_of({found.motion.translation - wanted.translation, found.motion.rotation - wanted.rotation},
                  kGyration),
        length_of(wanted, kGyration) + 1e-9);
  }
  EXPECT_GT(held, 500);
}

}  // namespace
}  // namespace palpate
