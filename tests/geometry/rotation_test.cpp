#include <palpate/geometry/rotation.h>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// What the smallest rotation from one to the other must do.
void expect_smallest_rotation(const Vector3d& from, const Vector3d& to, double tolerance) {
  const Quaterniond q = rotation_between(from, to);
  EXPECT_NEAR(q.norm(), 1.0, 1e-15);
  EXPECT_LT((q * from.normalized() - to.normalized()).norm(), tolerance) << to.transpose();
  const double angle = std::atan2(from.cross(to).norm(), from.dot(to));
  EXPECT_NEAR(q.angularDistance(Quaterniond::Identity()), angle, 1e-7) << to.transpose();
}

TEST(RotationBetween, IsTheSmallest) {
  const Vector3d from(0.3, -2.0, 0.5);
  for (int k = 0; k < 100; ++k) {
    const double u = k / 99.0 * 2.0 - 1.0, r = std::sqrt(1.0 - u * u), turn = 2.4 * k;
    expect_smallest_rotation(from, 1e3 * Vector3d(r * std::cos(turn), r * std::sin(turn), u), 1e-14);
  }
  expect_smallest_rotation(from, from, 1e-15);
}

TEST(RotationBetween, HalfATurnIsAboutAnAxisAcross) {
  for (const Vector3d& from : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(-1, 2, 3)}) {
    expect_smallest_rotation(from, -from, 1e-15);
    for (const double off : {1e-15, 1e-9, 1e-8, 1e-6}) {
      expect_smallest_rotation(from, -from + off * from.norm() * from.unitOrthogonal(), 3e-8);
    }
  }
}

TEST(RotationBetween, QuarterTurnByHand) {
  const Quaterniond q = rotation_between({2, 0, 0}, {0, 5, 0});
  const double h = std::numbers::sqrt2 / 2;
  EXPECT_LT((q.coeffs() - Quaterniond(h, 0, 0, h).coeffs()).norm(), 1e-15);
}

TEST(RotationVector, OfAQuarterTurnByHand) {
  const double h = std::numbers::sqrt2 / 2;
  const Vector3d turn = rotation_vector(Quaterniond(h, 0, h, 0));
  EXPECT_LT((turn - Vector3d(0, std::numbers::pi / 2, 0)).norm(), 1e-15);
  EXPECT_EQ(rotation_vector(Quaterniond::Identity()), Vector3d(0, 0, 0));
}

TEST(RotationVector, ThereAndBack) {
  for (const double angle : {1e-12, 1e-6, 0.5, 3.0}) {
    const Vector3d by = angle * Vector3d(2, -1, 2) / 3.0;
    EXPECT_LT((rotation_vector(rotation_by(by)) - by).norm(), 1e-15 + 1e-14 * angle) << angle;
  }
  EXPECT_EQ(rotation_by(Vector3d(0, 0, 0)).coeffs(), Quaterniond::Identity().coeffs());
}

TEST(TurnBetween, TakesOneToTheOther) {
  const Quaterniond from = rotation_by({0.3, -0.2, 0.9}), to = rotation_by({-0.7, 0.1, 0.4});
  EXPECT_LT((rotation_by(turn_between(from, to)) * from).angularDistance(to), 1e-14);
}

}  // namespace
}  // namespace palpate
