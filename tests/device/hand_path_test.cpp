#include <palpate/device/hand_path.h>

#include <algorithm>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

Trajectory path() {
  Trajectory t(3);
  t[0].t = 5.0;
  t[1].t = 6.0;
  t[1].pose = {{0.1, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vector3d::UnitZ()))};
  t[2].t = 8.0;
  t[2].pose = {{0.1, 0.2, 0}, t[1].pose.orientation};
  return t;
}

TEST(ToAndFro, GoesBackTheWayItCame) {
  const HandPath hand = to_and_fro(path());
  for (const double t : {0.0, 0.3, 1.0, 2.2, 3.0}) {
    EXPECT_TRUE(hand(t).position.isApprox(pose_at(path(), 5.0 + t).position));
    EXPECT_TRUE(hand(6.0 - t).position.isApprox(hand(t).position, 1e-9)) << t;
    EXPECT_TRUE(hand(60.0 + t).position.isApprox(hand(t).position, 1e-9)) << t;
  }
}

TEST(Tremor, IsAsLargeAsSaidAndFasterThanAHandIntends) {
  const HandPath still = [](double) { return Pose{}; };
  const HandPath hand = with_tremor(still, 1e-4);
  int crossings = 0;
  double largest = 0.0;
  for (int k = 1; k <= 10000; ++k) {
    const double x = hand(1e-3 * k).position.x(), before = hand(1e-3 * (k - 1)).position.x();
    crossings += (x > 0.0) != (before > 0.0) ? 1 : 0;
    largest = std::max(largest, std::abs(x));
  }
  EXPECT_NEAR(largest, 1e-4, 1e-5);
  EXPECT_GE(crossings, 2 * 8 * 10);
  EXPECT_LE(crossings, 2 * 12 * 10);
}

}  // namespace
}  // namespace palpate
