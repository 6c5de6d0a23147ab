// Forward of inverse.
#include <palpate/kinematics/inverse_kinematics.h>

#include <cstdlib>

#include <gtest/gtest.h>

#include <palpate/kinematics/chain_file.h>
#include <support/random_joints.h>

namespace palpate {
namespace {

int targets() { return std::getenv("PALPATE_LONG") != nullptr ? 1'000'000 : 10'000; }

TEST(InverseKinematics, ForwardOfInverseIsTheTarget) {
  const SerialChain chain = giant_chain();
  const ChainLimits limits(chain);
  ChainKinematics at(chain);
  std::mt19937_64 random(11);
  int missed = 0;
  double worst_way = 0.0, worst_turn = 0.0;
  for (int k = 0; k < targets(); ++k) {
    at.set(test::posture(limits, random));
    const Pose target = at.tip();
    const auto q = inverse_kinematics(chain, target, limits.rest);
    if (!q.has_value()) {
      ++missed;
      continue;
    }
    ASSERT_TRUE(((*q - limits.lower).array() >= 0.0).all() && ((limits.upper - *q).array() >= 0.0).all());
    at.set(*q);
    const Vector6d off = difference(at.tip(), target);
    worst_way = std::max(worst_way, off.head<3>().norm());
    worst_turn = std::max(worst_turn, off.tail<3>().norm());
  }
  EXPECT_EQ(missed, 0);
  EXPECT_LE(worst_way, 1e-6);
  EXPECT_LE(worst_turn, 1e-6);
  RecordProperty("worst_way", std::to_string(worst_way));
}

TEST(InverseKinematics, SaysSoWhereNothingReaches) {
  const SerialChain chain = giant_chain();
  const ChainLimits limits(chain);
  Pose target;
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(9, 0, 1), Eigen::Vector3d(0, 0, 5), Eigen::Vector3d(0, 0, 0.3)}) {
    target.position = place;
    EXPECT_FALSE(inverse_kinematics(chain, target, limits.rest).has_value()) << place.transpose();
  }
  target.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(inverse_kinematics(chain, target, limits.rest).has_value());
}

}  // namespace
}  // namespace palpate
