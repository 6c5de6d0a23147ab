#include <palpate/geometry/similarity.h>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

const Quaterniond kTurn = Quaterniond(0.5, -0.7, 0.1, 0.3).normalized();
const Vector3d kShift(3.25, -41.5, 1.125);

// A quarter turn about z takes x to y: by hand.
TEST(Similarity, MirrorsThenTurnsThenScalesThenMoves) {
  const double h = std::sqrt(0.5);
  const Similarity s{2.0, {h, 0, 0, h}, {10, 20, 30}, true};
  EXPECT_TRUE((s * Vector3d(1, 0, 0)).isApprox(Vector3d(10, 18, 30), 1e-15));
  EXPECT_TRUE((s * Vector3d(0, 1, 0)).isApprox(Vector3d(8, 20, 30), 1e-15));
  EXPECT_TRUE((s * Vector3d(0, 0, 1)).isApprox(Vector3d(10, 20, 32), 1e-15));
}

TEST(Similarity, OrthogonalIsItsLinearPart) {
  for (const bool mirrored : {false, true}) {
    const Similarity s{0.42, kTurn, kShift, mirrored};
    const Matrix3d Q = s.orthogonal();
    EXPECT_TRUE((Q * Q.transpose()).isIdentity(1e-15));
    EXPECT_NEAR(Q.determinant(), mirrored ? -1.0 : 1.0, 1e-15);
    const Vector3d x(0.3, -1.2, 2.5);
    EXPECT_LT((s * x - (0.42 * (Q * x) + kShift)).norm(), 1e-14);
  }
}

TEST(Similarity, InverseTakesEveryPointBack) {
  for (const bool mirrored : {false, true}) {
    const Similarity s{0.42, kTurn, kShift, mirrored}, back = s.inverse();
    for (const Vector3d& x : {Vector3d(0, 0, 0), Vector3d(1, 2, 3), Vector3d(-7, 0.1, 5)}) {
      EXPECT_LT((back * (s * x) - x).norm(), 1e-13);
      EXPECT_LT((s * (back * x) - x).norm(), 1e-13);
    }
    EXPECT_EQ(back.mirrored, mirrored);
  }
}

}  // namespace
}  // namespace palpate
