#include <palpate/live/simulated_hand.h>

#include <cmath>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kTick = 1e-3;           // s
constexpr double kTremorReach = 0.5e-3;  // m

/// To and fro over 0.2 m in 4 s.
Pose own_way(double t) { return {{0.1 * std::sin(1.57 * t), 0.0, 0.3}, Quaterniond::Identity()}; }

struct SimulatedHandTest : testing::Test {
  ClientHand client;
  std::atomic<bool> moves_itself = true;
  HandPath hand = simulated_hand(own_way, client, moves_itself);
  double t = 0.0;

  /// Goes on for a time. \returns how far it gets from where it is at most. Unit: [m].
  double reach_in(double seconds) {
    const Vector3d from = hand(t).position;
    double reach = 0.0;
    for (const double until = t + seconds; t < until; t += kTick)
      reach = std::max(reach, (hand(t).position - from).norm());
    return reach;
  }
};

TEST_F(SimulatedHandTest, StaysWhereItIsWhileItDoesNotMoveItself) {
  EXPECT_GT(reach_in(4.0), 0.1);
  moves_itself = false;
  reach_in(0.5);
  EXPECT_LT(reach_in(30.0), kTremorReach);
  const Vector3d stood = hand(t).position;
  moves_itself = true;
  EXPECT_LT((hand(t + kTick).position - stood).norm(), kTremorReach) << "it goes on from there";
  EXPECT_GT(reach_in(4.0), 0.1);
}

TEST_F(SimulatedHandTest, StaysWhereAClientLeavesIt) {
  reach_in(1.0);
  const Vector3d left(0.05, -0.1, 0.2);
  client.put({left, Quaterniond::Identity()}, t);
  reach_in(1.0);
  EXPECT_FALSE(moves_itself);
  client.let_go();
  EXPECT_LT((hand(t).position - left).norm(), kTremorReach);
  EXPECT_LT(reach_in(30.0), kTremorReach);
  EXPECT_LT((hand(t).position - left).norm(), kTremorReach);
}

TEST_F(SimulatedHandTest, GoesItsOwnWayAgainWhenItIsToldTo) {
  client.put({{0.05, -0.1, 0.2}, Quaterniond::Identity()}, t);
  reach_in(1.0);
  client.let_go();
  reach_in(1.0);
  moves_itself = true;
  reach_in(2.0);
  EXPECT_GT(reach_in(4.0), 0.1);
  EXPECT_NEAR(hand(t).position.z(), 0.3, kTremorReach);
}

}  // namespace
}  // namespace palpate
