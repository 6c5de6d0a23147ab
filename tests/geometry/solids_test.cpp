// What is asked of solid ellipsoids that move.

#include <algorithm>

#include <gtest/gtest.h>

#include <palpate/geometry/solids.h>
#include <support/random_pairs.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Random;

// The support function of a sum is the sum of both: a solid that contains it reaches as far in all
// directions.
TEST(Solids, AContainingSolidHasAllThatIsWithinTheMargin) {
  Random random(71);
  double least = 1e300;
  for (int n = 0; n < 500; ++n) {
    const Ellipsoid solid = random.ellipsoid(0.1, 1e-3, 1e-1);
    const double margin = random.uniform(1e-4, 0.1);
    const Ellipsoid larger = containing(solid, margin);
    EXPECT_EQ(larger.center, solid.center);
    for (int k = 0; k < 100; ++k) {
      const Vector3d n_W = random.direction();
      const double more = larger.support(n_W) - solid.support(n_W) - margin;
      EXPECT_GT(more, -1e-12);
      least = std::min(least, more / margin);
    }
  }
  EXPECT_LT(least, 1e-3) << "needlessly large";
}

TEST(Solids, ABallWithinAMarginIsALargerBall) {
  const Ellipsoid ball{{1, 2, 3}, 0.02 * Eigen::Matrix3d::Identity()};
  const Ellipsoid larger = containing(ball, 0.005);
  EXPECT_TRUE(larger.axes.isApprox(0.025 * Eigen::Matrix3d::Identity(), 1e-12));
}

}  // namespace
}  // namespace palpate
