#include <palpate/servo/sustained_limit.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Asks for `force` for `seconds`, on ticks of `period`. \returns what is given at the end.
double hold(SustainedLimit& limit, double force, double seconds, double period = 1e-3) {
  double given = 0.0;
  for (int k = 0; k < std::lround(seconds / period); ++k) {
    given = std::min(force, limit.bound());
    limit.pass(given, period);
  }
  return given;
}

TEST(SustainedLimit, GivesThePeakForAWhileAndThenWhatIsHeldForEver) {
  SustainedLimit limit(4.0, 2.0);
  const double full = -SustainedLimit::kTime * std::log(1.0 - 0.5 / 4.0);  // 1.34 s: h = 1/2 = 4 (1 - e^-t/T)
  EXPECT_EQ(hold(limit, 9.0, full - 0.01), 4.0);
  EXPECT_LT(hold(limit, 9.0, 0.02), 4.0);
  double last = 4.0;
  for (int k = 0; k < 100; ++k) {
    const double now = hold(limit, 9.0, 1.0);
    EXPECT_LE(now, last);
    EXPECT_GE(now, 2.0);
    last = now;
  }
  EXPECT_NEAR(last, 2.0, 1e-3);
}

TEST(SustainedLimit, WhatIsHeldForEverIsHeldForEver) {
  SustainedLimit limit(4.0, 2.0);
  EXPECT_EQ(hold(limit, 2.0, 1000.0, 0.01), 2.0);
}

TEST(SustainedLimit, CoolsByTheTimeThatPasses) {
  SustainedLimit limit(4.0, 2.0);
  hold(limit, 4.0, 100.0);
  EXPECT_NEAR(limit.bound(), 2.0, 1e-3);
  limit.pass(0.0, SustainedLimit::kTime * std::log(4.0));  // h = 1/4
  EXPECT_EQ(limit.bound(), 4.0);
}

TEST(SustainedLimit, WhatHasNoLimitOfItsOwnIsNotLimited) {
  for (const double sustained : {0.0, 4.0}) {
    SustainedLimit limit(4.0, sustained);
    EXPECT_EQ(hold(limit, 9.0, 1000.0, 0.1), 4.0);
  }
}

// The mean of the square, as the motors feel it, in whatever way force and ticks change.
TEST(SustainedLimit, NoMeanIsEverAboveIt) {
  std::mt19937 random(18);
  std::uniform_real_distribution<double> force(0.0, 5.0), period(1e-4, 5e-3);
  SustainedLimit limit(4.0, 1.0);
  double mean = 0.0, asked = 0.0;
  for (int k = 0; k < 1'000'000; ++k) {
    if (random() % 1000 == 0) asked = force(random);
    const double dt = period(random), bound = limit.bound();
    const double given = std::min(asked, bound);
    limit.pass(given, dt);
    // By the trapezoid of the leaky integral, not by its closed form.
    mean = (mean * (1.0 - 0.5 * dt / SustainedLimit::kTime) + given * given * dt / SustainedLimit::kTime) /
           (1.0 + 0.5 * dt / SustainedLimit::kTime);
    ASSERT_LE(mean, 1.0 + 1e-6) << k;
    if (given >= 1.0) {
      ASSERT_LE(limit.bound(), bound + 1e-12) << "it rises under a hand that leans on it";
    }
  }
}

}  // namespace
}  // namespace palpate
