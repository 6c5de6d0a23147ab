// Ages of stamps of a clock that nobody has compared with this one's.
#include <palpate/gateway/stamp_clock.h>

#include <random>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

constexpr double kOneWay = 5e-4;    // s
constexpr double kOffset = 1234.5;  // of the publisher's clock, s

TEST(StampClock, AgeIsTheDelayBeyondTheLeastAndTheWayThereAndBack) {
  StampClock clock(kOneWay);
  std::mt19937 random(1);
  std::exponential_distribution<double> jitter(500.0);  // mean 2 ms
  for (int k = 0; k < 2000; ++k) clock.age(1e-3 * k + kOffset, 1e-3 * k + kOneWay + jitter(random));
  const double stamp = 2.0 + kOffset;
  EXPECT_NEAR(*clock.age(stamp, 2.0 + kOneWay), 2.0 * kOneWay, 1e-5);
  EXPECT_NEAR(*clock.age(stamp, 2.0 + kOneWay + 0.007), 2.0 * kOneWay + 0.007, 1e-5);
}

TEST(StampClock, AnEchoTellsTheDelay) {
  StampClock clock(kOneWay);
  const double delay = 0.004;
  const auto number = clock.echoes().ask(1.0);
  clock.echoes().answer(number, 1.0 + delay + kOffset, 1.0 + 2.0 * delay);
  EXPECT_NEAR(*clock.age(1.1 + kOffset, 1.1 + delay), 2.0 * delay, 1e-9) << "there and back";
}

TEST(StampClock, NothingIsKnownOfAStampOfTheFuture) {
  StampClock clock(kOneWay);
  ASSERT_TRUE(clock.age(1.0 + kOffset, 1.0));
  EXPECT_FALSE(clock.age(1.2 + kOffset, 1.001));
  EXPECT_TRUE(clock.age(1.002 + kOffset, 1.002)) << "and it has changed nothing";
  clock.reset();
  EXPECT_TRUE(clock.age(9.0 + kOffset, 1.003)) << "the clock was set";
}

TEST(StampClock, WhoIsResetForgetsWhatEchoesTold) {
  StampClock clock(kOneWay);
  const auto number = clock.echoes().ask(1.0);
  clock.echoes().answer(number, 1.0 + kOffset, 1.0);
  EXPECT_NEAR(*clock.age(1.1 + kOffset, 1.2), 0.1, 1e-9);
  clock.reset();
  EXPECT_NEAR(*clock.age(1.1 + kOffset, 1.2), 2.0 * kOneWay, 1e-9)
      << "the first of a clock that nothing is known of";
}

TEST(StampClock, FollowsAClockThatDrifts) {
  StampClock clock(kOneWay);
  constexpr double kDrift = 1e-4;
  for (int k = 0; k < 100000; ++k) {
    const double now = 1e-3 * k;
    const auto age = clock.age(now * (1.0 - kDrift) + kOffset, now);
    ASSERT_TRUE(age);
    ASSERT_LT(*age, 2.0 * kOneWay + 1.01 * kDrift * StampClock::kSeconds);
    ASSERT_GE(*age, 2.0 * kOneWay - 1e-9);
  }
}

}  // namespace
}  // namespace palpate::test
