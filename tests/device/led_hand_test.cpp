#include <palpate/device/led_hand.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Pose pose(const Vector3d& position, double turn = 0.0, const Vector3d& axis = Vector3d::UnitZ()) {
  return {position, Quaterniond(AngleAxisd(turn, axis))};
}

/// In 0.1 m rounds of two seconds: 0.31 m/s, a hand that explores.
Pose round_and_round(double t) {
  return pose({0.1 * std::cos(M_PI * t), 0.1 * std::sin(M_PI * t), 0}, 0.3 * std::sin(M_PI * t));
}

Pose still_aside(double) { return pose({0.02, 0, 0}, 0.1); }

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

double distance(const Pose& a, const Pose& b) { return (a.position - b.position).norm(); }
double turn(const Pose& a, const Pose& b) { return turn_between(a.orientation, b.orientation).norm(); }

/// A hand that is driven through time, and how fast it was.
struct Drive {
  explicit Drive(HandPath own) : hand(std::move(own), [this](double) { return lead; }) {}

  void to(double end, double step) {
    for (; t < end - 0.5 * step; t += step) {
      const Pose next = hand(t + step);
      speed = std::max(speed, distance(at, next) / step);
      turn_speed = std::max(turn_speed, turn(at, next) / step);
      at = next;
    }
  }
  void start() { at = hand(t); }
  void forget_speeds() { speed = turn_speed = 0.0; }

  std::optional<Pose> lead;
  LedHand hand;
  double t = 0.0;
  Pose at;
  double speed = 0.0, turn_speed = 0.0;
};

// Its way is another from one moment to the next, as where a clutch is released or another path is given.
TEST(LedHand, GoesAtTheSpeedOfAHandWhereItsOwnWayGoesOnElsewhere) {
  Vector3d shift = Vector3d::Zero();
  Drive drive([&](double t) {
    Pose there = round_and_round(t);
    there.position += shift;
    return there;
  });
  drive.start();
  drive.to(0.5, 1e-3);
  drive.forget_speeds();
  shift = {0.2, -0.1, 0.1};
  drive.to(1.5, 1e-3);
  EXPECT_LE(drive.speed, LedHand::kSpeed + 1e-9);
  EXPECT_GT(drive.speed, 0.9);
  Pose there = round_and_round(drive.t);
  there.position += shift;
  EXPECT_LT(distance(drive.at, there), 1e-9);
}

TEST(LedHand, GoesExactlyItsOwnWayUntilItIsLed) {
  LedHand hand(round_and_round, [](double) { return std::nullopt; });
  for (const double t : {3.0, 3.001, 3.0015, 3.5, 3.5, 7.0})
    EXPECT_TRUE(same(hand(t), round_and_round(t))) << t;
}

TEST(LedHand, ReachesWhereItIsLed) {
  Drive drive(still_aside);
  drive.start();
  drive.lead = pose({0.2, -0.1, 0.3}, 2.5, Vector3d(1, 2, -2).normalized());
  drive.to(2.0, 1e-3);
  EXPECT_LE(distance(drive.at, *drive.lead), 1e-6);
  EXPECT_LE(turn(drive.at, *drive.lead), 1e-6);
  EXPECT_NEAR(drive.at.orientation.norm(), 1.0, 1e-12);
}

// 0.4 m at 1 m/s, less what it slows down in: that is no smoothing of seconds.
TEST(LedHand, IsNotSlowerThanItMayBe) {
  Drive drive([](double) { return Pose{}; });
  drive.start();
  drive.lead = pose({0.4, 0, 0});
  drive.to(0.3, 1e-3);
  EXPECT_NEAR(drive.at.position.x(), 0.3, 1e-9);
  EXPECT_EQ(drive.at.position.y(), 0.0);
  drive.to(0.6, 1e-3);
  EXPECT_NEAR(drive.at.position.x(), 0.4, 1e-5);
}

TEST(LedHand, FollowsASmallChangeInItsFollowTime) {
  Drive drive([](double) { return Pose{}; });
  drive.start();
  drive.lead = pose({0.01, 0, 0}, 0.01);
  drive.to(LedHand::kFollow, 1e-3);
  EXPECT_NEAR(drive.at.position.x(), 0.01 * (1.0 - std::exp(-1.0)), 1e-9);
  EXPECT_NEAR(turn(drive.at, Pose{}), 0.01 * (1.0 - std::exp(-1.0)), 1e-9);
}

TEST(LedHand, DoesNotDependOnHowOftenItIsAsked) {
  Drive coarse(still_aside), fine(still_aside);
  for (Drive* drive : {&coarse, &fine}) {
    drive->start();
    drive->lead = pose({0.03, 0.005, 0}, 0.15);
  }
  coarse.to(0.05, 1e-3);
  fine.to(0.05, 5e-5);
  EXPECT_LE(distance(coarse.at, fine.at), 1e-9);
  EXPECT_LE(turn(coarse.at, fine.at), 1e-9);
}

class LedHandSpeed : public testing::TestWithParam<double> {};

// Steps of a loop, and those that the simulated device takes within one.
INSTANTIATE_TEST_SUITE_P(Steps, LedHandSpeed, testing::Values(2e-3, 1e-3, SimulatedDevice::kStep));

TEST_P(LedHandSpeed, IsThatOfAHandWhereverItIsLed) {
  Drive drive(still_aside);
  drive.start();
  int k = 0;
  for (const Pose& goal : {pose({10, 0, 0}, 3.0), pose({-10, 5, 0}, -3.0, Vector3d::UnitX()), pose({0, 0, 0}),
                           pose({1e6, 1e6, 1e6}, M_PI, Vector3d::UnitY())}) {
    drive.lead = goal;
    drive.to(0.4 * ++k, GetParam());
  }
  EXPECT_LE(drive.speed, LedHand::kSpeed * (1.0 + 1e-6));
  EXPECT_LE(drive.turn_speed, LedHand::kTurnSpeed * (1.0 + 1e-6));
  EXPECT_GE(drive.speed, 0.99 * LedHand::kSpeed);
  EXPECT_GE(drive.turn_speed, 0.99 * LedHand::kTurnSpeed);
}

TEST_P(LedHandSpeed, IsThatOfAHandOnTheWayBack) {
  for (const HandPath& own : {HandPath(still_aside), HandPath(round_and_round)}) {
    Drive drive(own);
    drive.start();
    drive.lead = pose({0.3, 0.2, 0}, 2.0);
    drive.to(1.0, GetParam());
    drive.lead.reset();
    drive.forget_speeds();
    drive.to(4.0, GetParam());
    EXPECT_LE(drive.speed, LedHand::kSpeed * (1.0 + 1e-6));
    EXPECT_LE(drive.turn_speed, LedHand::kTurnSpeed * (1.0 + 1e-6));
  }
}

TEST_P(LedHandSpeed, IsThatOfAHandOnTheWayBackFromATurnAlone) {
  Drive drive(still_aside);
  drive.start();
  drive.lead = pose(still_aside(0).position, 2.0);
  drive.to(1.0, GetParam());
  drive.lead.reset();
  drive.to(4.0, GetParam());
  EXPECT_LE(drive.turn_speed, LedHand::kTurnSpeed * (1.0 + 1e-6));
}

TEST(LedHand, GoesBackExactlyToARestingPlace) {
  Drive drive(still_aside);
  drive.start();
  drive.lead = pose({0.3, 0.2, 0}, 2.0);
  drive.to(1.0, 1e-3);
  drive.lead.reset();
  drive.to(3.0, 1e-3);
  EXPECT_TRUE(same(drive.at, still_aside(drive.t))) << distance(drive.at, still_aside(drive.t));
}

TEST(LedHand, GoesOnWithItsOwnWayWhereItWasTaken) {
  double asked = 0.0;
  Drive drive([&](double t) { return round_and_round(asked = t); });
  drive.start();
  drive.to(0.7, 1e-3);
  drive.lead = pose({0.3, 0.2, 0}, 2.0);
  drive.to(1.7, 1e-3);
  drive.lead.reset();
  drive.to(1.701, 1e-3);
  EXPECT_NEAR(asked, 0.7, 1e-9);
  drive.to(6.0, 1e-3);
  EXPECT_TRUE(same(drive.at, round_and_round(asked)));
  EXPECT_GT(asked, 0.7 + 2.0);
}

/// Leads a hand along corners, at 0.5 m/s.
void lead_along(Drive& drive, const std::vector<Vector3d>& corners) {
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const double length = (corners[k] - corners[k - 1]).norm(), begin = drive.t;
    while (drive.t < begin + length / 0.5) {
      drive.lead = pose(corners[k - 1] + (drive.t - begin) * 0.5 / length * (corners[k] - corners[k - 1]));
      drive.to(drive.t + 1e-3, 1e-3);
    }
  }
  drive.lead = pose(corners.back());
  drive.to(drive.t + 0.5, 1e-3);
}

/// How far the hand goes off straight ways between corners, until it is at the first of them; and how long
/// that takes.
struct WayBack {
  double off = 0.0, seconds = 0.0;
};
WayBack let_go(Drive& drive, const std::vector<Vector3d>& corners) {
  WayBack back;
  drive.lead.reset();
  while (drive.at.position != corners.front() && back.seconds < 60.0) {
    drive.to(drive.t + 1e-3, 1e-3);
    back.seconds += 1e-3;
    double least = 1e9;
    for (std::size_t k = 1; k < corners.size(); ++k) {
      const Vector3d way = corners[k] - corners[k - 1], from = drive.at.position - corners[k - 1];
      least = std::min(least, (from - std::clamp(from.dot(way) / way.squaredNorm(), 0.0, 1.0) * way).norm());
    }
    back.off = std::max(back.off, least);
  }
  return back;
}

// The straight way would lead through what it was led around.
TEST(LedHand, GoesBackAsItWasLed) {
  const std::vector<Vector3d> corners{{0, 0, 0}, {0, 0, 0.2}, {0.3, 0, 0.2}, {0.3, 0, 0}};
  Drive drive([](double) { return Pose{}; });
  drive.start();
  lead_along(drive, corners);
  const WayBack back = let_go(drive, corners);
  EXPECT_LT(back.off, 0.012) << "it cuts corners while it follows";
  EXPECT_NEAR(back.seconds, 0.7 / LedHand::kBackSpeed, 0.1);
}

TEST(LedHand, GoesBackWithoutTheRounds) {
  const Vector3d begin(0, 0, 0), foot(0, 0, 0.1);
  std::vector<Vector3d> led{begin, foot};
  for (int round = 0; round < 5; ++round)
    led.insert(led.end(), {{0.2, 0, 0.1}, {0.2, 0.2, 0.1}, {0, 0.2, 0.1}, foot});
  Drive drive([](double) { return Pose{}; });
  drive.start();
  lead_along(drive, led);
  const WayBack back = let_go(drive, led);
  EXPECT_LT(back.off, 0.012);
  EXPECT_LT(back.seconds, 1.1 / LedHand::kBackSpeed) << "one round at most";
}

// More places than it remembers.
TEST(LedHand, GoesBackALongWay) {
  std::vector<Vector3d> led{{0, 0, 0}};
  for (int k = 1; k <= 16; ++k) led.emplace_back(k % 2 == 0 ? 0.0 : 0.5, 0.1 * k, 0.01 * k);
  Drive drive([](double) { return Pose{}; });
  drive.start();
  lead_along(drive, led);
  const WayBack back = let_go(drive, led);
  EXPECT_LT(back.off, 0.02);
  EXPECT_GT(back.seconds, 7.0 / LedHand::kBackSpeed);
  EXPECT_LT(back.seconds, 60.0);

  // A short way after that is remembered as finely as a first one: its end is not taken for its beginning.
  const std::vector<Vector3d> around{{0, 0, 0}, {0, 0, 0.007}, {0.007, 0, 0.007}, {0.007, 0, 0}};
  lead_along(drive, around);
  EXPECT_GT(let_go(drive, around).seconds, 1.3 * 0.007 / LedHand::kBackSpeed) << "not straight";
}

// What it was led around is not there any more.
TEST(LedHand, GoesStraightToAnOwnWayThatIsElsewhere) {
  Vector3d place = Vector3d::Zero();
  Drive drive([&](double) { return pose(place); });
  drive.start();
  lead_along(drive, {{0, 0, 0}, {0, 0, 0.3}, {0.3, 0, 0.3}});
  place = {0.3, 0, 0};
  drive.lead.reset();
  drive.to(drive.t + 0.6, 1e-3);
  EXPECT_EQ(drive.at.position, place);
}

TEST(LedHand, MayBeLedAgainAtOnce) {
  Drive drive(still_aside);
  drive.start();
  for (int k = 0; k < 40; ++k) {
    drive.lead = k % 2 == 0 ? std::optional<Pose>(pose({0.3, 0, 0}, 1.0)) : std::nullopt;
    drive.to(0.02 * (k + 1), 1e-3);
  }
  EXPECT_LE(drive.speed, LedHand::kSpeed * (1.0 + 1e-6));
}

TEST(LedHand, StaysWhereItIsWhileNoTimePasses) {
  Drive drive(still_aside);
  drive.start();
  drive.lead = pose({0.3, 0.2, 0}, 2.0);
  drive.to(0.1, 1e-3);
  const Pose before = drive.at;
  EXPECT_EQ(distance(drive.hand(drive.t), before), 0.0);
}

}  // namespace
}  // namespace palpate
