// The governor of the reference client, on a clock of the test's own.
#include <client/palpate_client.h>

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/not_finite.h>
#include <support/tick.h>

namespace palpate_client {
namespace {

using palpate::test::kInfinity;
using palpate::test::kNan;
using palpate::test::kTick;

constexpr double kForce = 4.0;                        // N
constexpr double kForceMax = 10.0, kTorqueMax = 0.5;  // N, N m

double norm(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

class WrenchGovernorTest : public testing::Test {
 protected:
  void take(double force, double torque = 0.0) { governor.take({{0, 0, force}, {torque, 0, 0}}, now, now); }
  double show() {
    const Wrench shown = governor.show(now);
    return shown.force[2];
  }
  /// Ticks in which the same force comes, and the last that was shown.
  double hold(double force, double seconds) {
    double shown = 0.0;
    for (const double end = now + seconds; now < end; now += kTick) {
      take(force);
      shown = show();
    }
    return shown;
  }
  /// Through the gate, until all of `force` is shown; the last wrench came at the time `now`.
  void open(double force = kForce) {
    hold(0.0, 2 * kTick);
    hold(force, WrenchGovernor::kRise);
    take(force);
    ASSERT_EQ(show(), force);
  }
  /// Ticks in which nothing comes, to the end of the fall from `from`.
  void expect_fall(double from) {
    double last = from;
    for (const double end = now + WrenchGovernor::kFall; now < end - 1e-9; now += kTick) {
      const double shown = show();
      EXPECT_LE(shown, last);
      EXPECT_GE(shown, last - 0.21 * from) << "a line, not a step";
      last = shown;
    }
    EXPECT_EQ(show(), 0.0);
  }

  double now = 100.0;
  WrenchGovernor governor{{kForceMax, kTorqueMax}};
};

TEST_F(WrenchGovernorTest, ThereIsNothingBeforeTheFirstWrench) {
  EXPECT_EQ(show(), 0.0);
  now += 1.0;
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, SilenceEndsInZeroAtFiftyMilliseconds) {
  open();
  const double last_came = now;
  now = last_came + 0.0449;
  EXPECT_EQ(show(), kForce);
  now = last_came + 0.0451;
  EXPECT_EQ(show(), kForce) << "the line begins here";
  now = last_came + 0.04755;  // half of the 4.9 ms that are left
  EXPECT_NEAR(show(), 0.5 * kForce, 1e-9);
  now = last_came + 0.0499;
  EXPECT_GT(show(), 0.0);
  now = last_came + 0.05;
  EXPECT_EQ(show(), 0.0);
  now = last_came + 10.0;
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, WhoAsksOnlyAfterTheSilenceGetsZeroAtOnce) {
  open();
  now += 0.0501;
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, AForceThatHasBegunToFallDoesNotComeBackByItself) {
  open();
  now += 0.047;
  show();
  EXPECT_EQ(hold(kForce, 1.0), 0.0);
}

TEST_F(WrenchGovernorTest, AfterASilenceAWrenchMustBeSmallAndThenTheForceRises) {
  open();
  now += 0.06;
  show();
  EXPECT_EQ(hold(kForce, 1.0), 0.0);
  EXPECT_EQ(hold(0.06 * kForceMax, 0.1), 0.0) << "the gate is at 5 %";
  take(0.04 * kForceMax);
  EXPECT_EQ(show(), 0.0);
  const double opened = now;
  for (double last = 0.0; now < opened + 0.2; now += kTick) {
    take(kForce);
    const double shown = show();
    EXPECT_LE(shown - last, kForce * kTick / WrenchGovernor::kRise + 1e-9);
    EXPECT_NEAR(shown, kForce * std::min(1.0, (now - opened) / WrenchGovernor::kRise), 1e-9);
    last = shown;
  }
}

TEST_F(WrenchGovernorTest, ATorqueThatIsNotSmallKeepsTheGateClosedToo) {
  for (int k = 0; k < 200; ++k, now += kTick) {
    take(0.0, 0.06 * kTorqueMax);
    EXPECT_EQ(norm(governor.show(now).torque), 0.0);
  }
  take(0.0, 0.04 * kTorqueMax);
  show();
  now += 0.04;
  EXPECT_GT(norm(governor.show(now).torque), 0.0);
}

TEST_F(WrenchGovernorTest, WhatIsNotFiniteIsNeverShown) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (const bool in_torque : {false, true}) {
      open();
      in_torque ? take(kForce, bad) : take(bad);
      expect_fall(kForce);
      EXPECT_EQ(hold(kForce, 1.0), 0.0) << "through the gate alone";
    }
  }
}

TEST_F(WrenchGovernorTest, WhatIsNoMessageOrALossOfTheConnectionEndsInZero) {
  open();
  governor.fail();
  expect_fall(kForce);
  EXPECT_EQ(hold(kForce, 1.0), 0.0);
  open();
}

TEST_F(WrenchGovernorTest, NoWrenchFromBeforeAFailureOpensTheGate) {
  open();
  hold(0.03 * kForceMax, 0.01);
  governor.fail();
  for (const double end = now + 0.04; now < end; now += kTick) show();
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, AFailureLateInASilenceDoesNotLengthenIt) {
  open();
  const double last_came = now;
  now = last_came + 0.044;
  EXPECT_EQ(show(), kForce);
  now = last_came + 0.048;
  governor.fail();
  EXPECT_EQ(show(), kForce);
  now = last_came + 0.05;
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, WhatIsTooLargeIsScaledDownInItsDirection) {
  open();
  governor.take({{30, 0, 40}, {0, -3, 4}}, now, now);
  const Wrench shown = governor.show(now);
  EXPECT_NEAR(shown.force[0], 6.0, 1e-12);
  EXPECT_NEAR(shown.force[2], 8.0, 1e-12);
  EXPECT_NEAR(shown.torque[1], -0.3, 1e-12);
  EXPECT_NEAR(shown.torque[2], 0.4, 1e-12);
  governor.take({{1e308, 1e308, 1e308}, {-1e308, 0, 0}}, now, now);
  EXPECT_LE(norm(governor.show(now).force), kForceMax * (1 + 1e-12));
  EXPECT_LE(norm(governor.show(now).torque), kTorqueMax * (1 + 1e-12));
}

TEST_F(WrenchGovernorTest, ADeviceWithoutMotorsForTheOrientationGetsNoTorque) {
  WrenchGovernor three_axes({kForceMax, 0.0});
  three_axes.show(now);
  three_axes.take({{0, 0, 0}, {1, 2, 3}}, now, now);
  three_axes.show(now);
  three_axes.show(now);
  now += 0.04;
  three_axes.take({{0, 0, 1}, {1, 2, 3}}, now, now);
  EXPECT_EQ(norm(three_axes.show(now).torque), 0.0);
  EXPECT_GT(norm(three_axes.show(now).force), 0.0);
}

TEST_F(WrenchGovernorTest, ASilenceThatNoCallHasSeenCounts) {
  open();
  now += 0.04;
  EXPECT_EQ(show(), kForce);
  now += 0.02;  // 60 ms after the last wrench
  take(kForce);
  EXPECT_EQ(show(), kForce) << "the line begins";
  EXPECT_EQ(hold(kForce, 0.1), 0.0);
}

TEST_F(WrenchGovernorTest, AServoThreadThatWasHeldUpGoesThroughTheGate) {
  open();
  for (int k = 0; k < 60; ++k, now += kTick) take(kForce);
  EXPECT_EQ(show(), 0.0) << "the motors may have been switched off meanwhile: no step for the hand";
  EXPECT_EQ(hold(kForce, 0.1), 0.0);
  open();
}

// By an hour, while the gate has been open for less.
TEST_F(WrenchGovernorTest, AClockThatIsSetBackGoesThroughTheGate) {
  open();
  now -= 3600.0;
  take(kForce);
  EXPECT_EQ(show(), 0.0);
  EXPECT_EQ(hold(kForce, 0.1), 0.0);
  open();
}

TEST_F(WrenchGovernorTest, SilenceIsCountedFromThePoseThatIsAnswered) {
  open();
  const double measured = now;
  for (; now < measured + 0.0449; now += kTick) {
    governor.take({{0, 0, kForce}, {}}, measured, now);  // the program goes on, the hand is silent
    EXPECT_EQ(show(), kForce);
  }
  now = measured + 0.05;
  governor.take({{0, 0, kForce}, {}}, measured, now);
  EXPECT_EQ(show(), 0.0);
}

TEST_F(WrenchGovernorTest, WrenchesThatComeLateAreShownAndThoseThatComeTooLateAreNot) {
  const auto come = [&](double late) {
    double shown = 0.0;
    for (int k = 0; k < 150; ++k, now += kTick) {
      governor.take({{0, 0, k < 2 ? 0.0 : kForce}, {}}, now - late, now);
      shown = show();
    }
    return shown;
  };
  EXPECT_EQ(come(0.04), kForce);
  EXPECT_EQ(come(0.051), 0.0);
  EXPECT_EQ(come(kNan), 0.0) << "without a stamp";
  EXPECT_EQ(come(0.04), kForce);
}

TEST_F(WrenchGovernorTest, RefusesLimitsThatAreNone) {
  EXPECT_THROW(WrenchGovernor({0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(WrenchGovernor({kNan, 0.0}), std::invalid_argument);
  EXPECT_THROW(WrenchGovernor({kInfinity, 0.0}), std::invalid_argument);
  EXPECT_THROW(WrenchGovernor({1.0, -1.0}), std::invalid_argument);
}

/// Whatever comes in whatever order: what is shown is bounded, zero after 50 ms, and after a failure, zero
/// until a small wrench has come.
TEST_F(WrenchGovernorTest, HoldsInRandomOrder) {
  std::mt19937_64 random(20261124);
  const auto draw = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  double came = -kInfinity, must_be_zero_at = -kInfinity;
  bool failed = true, small_since = false;
  double largest = 0.0;
  for (int k = 0; k < 1'000'000; ++k) {
    const double what = draw(0, 1);
    now += what < 0.001 ? draw(0, 0.2) : draw(0, 0.002);
    if (what < 0.9) {
      const double force =
          std::uniform_int_distribution(0, 20)(random) == 0 ? 0.1 : draw(-2 * kForceMax, 2 * kForceMax);
      take(force);
      came = now;
      small_since = small_since || std::abs(force) <= 0.05 * kForceMax;
    } else if (what < 0.902) {
      what < 0.901 ? governor.fail() : take(kNan);
      failed = true;
      small_since = false;
      must_be_zero_at = kInfinity;
    }
    if (draw(0, 1) < 0.2) continue;
    const double shown = std::abs(show());
    largest = std::max(largest, shown);
    ASSERT_TRUE(shown <= kForceMax * (1 + 1e-12)) << shown;
    if (now - came >= WrenchGovernor::kSilence) {
      ASSERT_EQ(shown, 0.0);
    }
    if (failed && must_be_zero_at == kInfinity) must_be_zero_at = now + WrenchGovernor::kFall;
    if (failed && small_since) failed = false;
    if (failed && now >= must_be_zero_at) {
      ASSERT_EQ(shown, 0.0);
    }
  }
  EXPECT_GT(largest, 0.9 * kForceMax) << "it showed something";
}

TEST_F(WrenchGovernorTest, TakesNothingFromTheHeap) {
  const palpate::test::AllocationGuard guard;
  open();
  governor.fail();
  show();
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate_client
