// Motion along one axis, whatever is wanted of it.
#include <palpate/servo/limited_axis.h>

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <support/uniform.h>

namespace palpate {
namespace {

using test::uniform;

constexpr double kRounding = 1e-9;
const AxisLimits kLimits{300.0, 6.0, 1.2, -0.5, 0.8};

void check(const AxisState& s, const AxisState& before, const AxisLimits& l, double dt) {
  ASSERT_GE(s.position, l.lower - kRounding);
  ASSERT_LE(s.position, l.upper + kRounding);
  ASSERT_LE(std::abs(s.velocity), l.velocity * (1 + kRounding));
  ASSERT_LE(std::abs(s.acceleration), l.acceleration * (1 + kRounding));
  ASSERT_LE(std::abs(s.acceleration - before.acceleration), l.jerk * dt * (1 + kRounding) + 1e-12);
  ASSERT_NEAR(s.position, before.position + dt * before.velocity, 0.51 * dt * dt * l.acceleration + 1e-12);
}

TEST(LimitedAxis, StaysWithinItsLimitsForEverySequence) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 200; ++run) {
    AxisState s;
    double wanted = 0.0;
    for (int k = 0; k < 3000; ++k) {
      if (random() % 100 == 0) {
        const double share = uniform(random, -1, 1);
        wanted = share * std::pow(10.0, uniform(random, -2, 4));
      }
      const double dt = random() % 50 == 0 ? 8e-3 : uniform(random, 0.1e-3, 2e-3);
      const AxisState before = s;
      s = random() % 20 == 0 ? stopping(s, kLimits, dt) : stepped(s, kLimits, wanted, dt);
      check(s, before, kLimits, dt);
      if (testing::Test::HasFatalFailure()) FAIL() << run << ", " << k;
    }
  }
}

TEST(LimitedAxis, UsesAllThatItMay) {
  AxisState s;
  double fastest = 0.0;
  for (int k = 0; k < 3000; ++k) {
    s = stepped(s, kLimits, 1e3, 1e-3);
    fastest = std::max(fastest, s.velocity);
  }
  EXPECT_NEAR(s.position, kLimits.upper, 1e-4);
  EXPECT_NEAR(s.velocity, 0.0, 1e-3);
  AxisLimits free = kLimits;
  free.upper = 1e9;
  for (int k = 0; k < 3000; ++k) s = stepped(s, free, 1e3, 1e-3);
  EXPECT_NEAR(s.velocity, free.velocity, 1e-4);
}

// The most that ends at full speed: v + a dt / 2 + a^2 / 2 J = V for 0.15 mm/s below it, a^2 + 0.3 a - 0.09 =
// 0.
TEST(LimitedAxis, GoesAsFarTowardsWhatIsWantedAsItMay) {
  const AxisLimits limits{300.0, 6.0, 1.2};
  const AxisState end = stepped({0.0, 1.2 - 0.15e-3, 0.0}, limits, 6.0, 1e-3);
  EXPECT_NEAR(end.acceleration, -0.15 + std::sqrt(0.0225 + 0.09), 2e-4);
}

TEST(LimitedAxis, FollowsWhatIsWithinTheLimitsExactly) {
  AxisState s;
  for (int k = 0; k < 1000; ++k) {
    const double wanted = 0.5 * std::sin(5e-3 * k);
    const AxisState before = s;
    s = stepped(s, kLimits, wanted, 1e-3);
    ASSERT_DOUBLE_EQ(s.acceleration, wanted);
    ASSERT_NEAR(s.velocity, before.velocity + 0.5e-3 * (before.acceleration + wanted), 1e-15);
  }
}

// Downward, and already turning: v t + a t^2 / 2 - J t^3 / 6 at v + a t - J t^2 / 2 = 0 is 0.2544 mm below.
TEST(LimitedAxis, CountsWhereItTurns) {
  const double v = -0.05, a = 6.0, J = 300.0, t = (a - std::sqrt(a * a + 2.0 * J * v)) / J;
  const double lowest = v * t + a * t * t / 2.0 - J * t * t * t / 6.0;
  ASSERT_NEAR(lowest, -0.2544e-3, 1e-7);
  AxisLimits limits{J, 6.0, 1.2, lowest - 1e-6, 1.0};
  EXPECT_TRUE(can_stop({0.0, v, a}, limits));
  limits.lower = lowest + 1e-6;
  EXPECT_FALSE(can_stop({0.0, v, a}, limits));
  limits = {J, 6.0, 1.2, -1.0, -lowest + 1e-6};
  EXPECT_TRUE(can_stop({0.0, -v, -a}, limits));
  limits.upper = -lowest - 1e-6;
  EXPECT_FALSE(can_stop({0.0, -v, -a}, limits));
}

// At full speed as soon as the acceleration, which is full, is gone.
TEST(LimitedAxis, TakesTheStatedTimeWhereItIsWorst) {
  const double A = kLimits.acceleration, J = kLimits.jerk;
  const AxisState worst{-0.5, kLimits.velocity - 0.5 * A * A / J, A};
  EXPECT_TRUE(can_stop(worst, {J, A, kLimits.velocity}));
  EXPECT_NEAR(stop_time(kLimits), 1.2 / 6.0 + 2.0 * 6.0 / 300.0, 1e-15);
  const double before = 1e-3;
  const AxisState almost = stopping(worst, kLimits, stop_time(kLimits) - before);
  EXPECT_NEAR(almost.acceleration, -J * before, 1e-9);
  EXPECT_NEAR(almost.velocity, 0.5 * J * before * before, 1e-9);
}

TEST(LimitedAxis, ComesToRestInTheStatedTimeHoweverItIsSampled) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 5000; ++run) {
    AxisState s{0.0, uniform(random, -1.2, 1.2), uniform(random, -6, 6)};
    if (!can_stop(s, {kLimits.jerk, kLimits.acceleration, kLimits.velocity})) continue;
    const AxisState at_once = stopping(s, kLimits, stop_time(kLimits) * (1 + 1e-12));
    EXPECT_EQ(at_once.velocity, 0.0);
    EXPECT_EQ(at_once.acceleration, 0.0);
    double t = 0.0;
    while (t < stop_time(kLimits) * (1 + 1e-9)) {
      const double dt = uniform(random, 0.3e-3, 3e-3);
      s = stopping(s, kLimits, dt);
      t += dt;
    }
    ASSERT_NEAR(s.velocity, 0.0, 1e-9);
    ASSERT_NEAR(s.position, at_once.position, 1e-9);
  }
}

}  // namespace
}  // namespace palpate
