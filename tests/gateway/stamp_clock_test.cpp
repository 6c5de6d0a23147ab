// Ages of stamps of a clock that nobody has compared with this one's.
#include <palpate/gateway/stamp_clock.h>

#include <random>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

using Verdict = StampClock::Verdict;

constexpr double kOneWay = 5e-4;    // s
constexpr double kLimit = 0.02;     // s
constexpr double kOffset = 1234.5;  // of the publisher's clock, s
constexpr double kPeriod = 2e-3;    // s

/// A publisher whose messages arrive in the order in which it sends them.
struct Line {
  StampClock clock{kOneWay, kLimit};
  double sent = 0.0, arrived = 0.0;
  double latency = kOneWay, offset = kOffset;
  int set = 0;  ///< how often the clock is known to have been set
  StampClock::Check last;

  StampClock::Check send(double after = kPeriod) {
    sent += after;
    arrived = std::max(arrived, sent + latency);
    last = clock.check(sent + offset, arrived);
    set += last.clock_set ? 1 : 0;
    return last;
  }
  /// \returns the number of usable messages in the next `seconds`.
  int usable(double seconds) {
    int count = 0;
    for (const double end = sent + seconds; sent < end;) count += send().verdict == Verdict::kUsable ? 1 : 0;
    return count;
  }
};

TEST(StampClock, AgeIsTheDelayBeyondTheLeastAndTheWayThereAndBack) {
  StampClock clock(kOneWay, kLimit);
  std::mt19937 random(1);
  std::exponential_distribution<double> jitter(500.0);  // mean 2 ms
  double arrived = 0.0;
  for (int k = 0; k < 2000; ++k) {
    arrived = std::max(arrived, 1e-3 * k + kOneWay + jitter(random));
    clock.check(1e-3 * k + kOffset, arrived);
  }
  EXPECT_NEAR(clock.check(2.1 + kOffset, 2.1 + kOneWay).age, 2.0 * kOneWay, 2e-5);
  EXPECT_NEAR(clock.check(2.2 + kOffset, 2.2 + kOneWay + 0.007).age, 2.0 * kOneWay + 0.007, 4e-5);
}

TEST(StampClock, AnEchoTellsTheDelay) {
  StampClock clock(kOneWay, kLimit);
  const double delay = 0.004;
  const auto number = clock.echoes().ask(1.0);
  clock.echoes().answer(number, 1.0 + delay + kOffset, 1.0 + 2.0 * delay);
  EXPECT_NEAR(clock.check(1.1 + kOffset, 1.1 + delay).age, 2.0 * delay, 1e-9) << "there and back";
  EXPECT_NEAR(clock.check(7.1 + kOffset, 7.1 + delay).age, 2.0 * delay, 1e-3) << "long after it";
}

TEST(StampClock, WithAnEchoAnAgeMayBeShorterThanThatOfTheAssumedDelay) {
  StampClock clock(kOneWay, kLimit);
  const auto number = clock.echoes().ask(1.0);
  clock.echoes().answer(number, 1.0 + 5e-5 + kOffset, 1.0 + 1e-4);
  EXPECT_NEAR(clock.check(1.1 + kOffset, 1.1 + 5e-5).age, 1e-4, 1e-9);
}

TEST(StampClock, NothingIsKnownOfAStampOfTheFuture) {
  StampClock clock(kOneWay, kLimit);
  ASSERT_EQ(clock.check(1.0 + kOffset, 1.0).verdict, Verdict::kUsable);
  EXPECT_EQ(clock.check(1.2 + kOffset, 1.001).verdict, Verdict::kFuture);
  EXPECT_EQ(clock.check(1.002 + kOffset, 1.002).verdict, Verdict::kUsable) << "and it has changed nothing";
  clock.reset();
  EXPECT_EQ(clock.check(9.0 + kOffset, 1.003).verdict, Verdict::kUsable) << "another publisher";
}

TEST(StampClock, WhoIsResetForgetsWhatEchoesTold) {
  StampClock clock(kOneWay, 1.0);
  const auto number = clock.echoes().ask(1.0);
  clock.echoes().answer(number, 1.0 + kOffset, 1.0);
  EXPECT_NEAR(clock.check(1.1 + kOffset, 1.2).age, 0.1, 1e-9);
  clock.reset();
  EXPECT_NEAR(clock.check(1.1 + kOffset, 1.2).age, 2.0 * kOneWay, 1e-9)
      << "the first of a clock that nothing is known of";
}

TEST(StampClock, FollowsAClockThatDrifts) {
  for (const double slow : {StampClock::kDrift, -StampClock::kDrift}) {
    StampClock clock(kOneWay, kLimit);
    for (int k = 0; k < 100000; ++k) {
      const double now = 1e-3 * k;
      const auto check = clock.check(now * (1.0 - slow) + kOffset, now);
      ASSERT_EQ(check.verdict, Verdict::kUsable);
      ASSERT_NEAR(check.age, 2.0 * kOneWay, 1e-6);
    }
  }
}

TEST(StampClock, ALatencyThatRisesIsNotTakenForAClockThatWasSet) {
  for (const double rise : {0.03, 0.1, 0.5, 0.99, 1.5, 30.0}) {
    Line line;
    line.usable(3.0);
    line.latency += rise;
    EXPECT_EQ(line.usable(600.0), 0) << rise;
    EXPECT_EQ(line.set, 0) << rise;
    line.latency -= rise;
    EXPECT_GT(line.usable(30.0 + rise), 10000) << rise << ", once it is short again";
  }
}

TEST(StampClock, NorIsALatencyThatRisesAfterASilence) {
  for (const double silence : {0.5, 3.0, 100.0}) {
    Line line;
    line.usable(3.0);
    line.send(silence);
    line.latency += 0.5;
    EXPECT_EQ(line.usable(600.0), 0) << silence;
  }
}

TEST(StampClock, ALatencyThatRisesAlittleCountsForLong) {
  Line line;
  line.usable(3.0);
  line.latency += 0.01;
  EXPECT_GT(line.usable(20.0), 9000);
  EXPECT_GT(line.last.age, 0.01 + 2.0 * kOneWay - 21.0 * StampClock::kDrift);
}

TEST(StampClock, AClockThatWasSetIsTakenAfterASecondAndSaid) {
  for (const double step : {-0.05, -0.3, -1.5, -1000.0, 0.1, 2.0, 1000.0}) {
    Line line;
    line.usable(3.0);
    line.offset += step;
    EXPECT_EQ(line.usable(0.99 * StampClock::kSettle), 0) << step;
    line.usable(0.1);
    EXPECT_EQ(line.set, 1) << step;
    EXPECT_GT(line.usable(1.0), 490) << step;
    EXPECT_NEAR(line.last.age, 2.0 * kOneWay, 1e-4) << step;
  }
}

TEST(StampClock, AClockThatWasSetBackALittleMakesNothingLookNewer) {
  Line line;
  line.usable(3.0);
  line.offset -= 0.01;
  line.usable(1.0);
  EXPECT_EQ(line.last.verdict, Verdict::kUsable);
  EXPECT_GT(line.last.age, 0.01);
  EXPECT_EQ(line.set, 0);
}

// Its stamps may be later than those before, as those of a latency that has risen would be.
TEST(StampClock, AClockThatWasSetBackInASilenceIsTakenIfItsStampsGoBackOnly) {
  Line back;
  back.usable(3.0);
  back.offset -= 20.0;
  back.send(10.0);
  back.usable(1.1);
  EXPECT_EQ(back.set, 1);
  EXPECT_EQ(back.last.verdict, Verdict::kUsable);
  Line later;
  later.usable(3.0);
  later.offset -= 5.0;
  later.send(10.0);
  EXPECT_EQ(later.usable(600.0), 0);
}

TEST(StampClock, TheLatencyThatRisesWhileAClockSettlesCounts) {
  Line line;
  line.usable(3.0);
  line.offset -= 10.0;
  line.usable(0.5);
  line.latency += 0.5;
  EXPECT_EQ(line.usable(100.0), 0);
}

TEST(StampClock, AStrayMessageBeforeALatencyThatRisesIsNoClockThatWasSet) {
  for (const double stray : {-0.5, -10.0, 0.5, 10.0}) {
    Line line;
    line.usable(3.0);
    line.clock.check(line.sent + line.offset + stray, line.arrived);
    line.latency += 0.5;
    EXPECT_EQ(line.usable(100.0), 0) << stray;
    EXPECT_EQ(line.set, 0) << stray;
  }
}

TEST(StampClock, AClockWhoseStampsStandStillIsNotTaken) {
  Line line;
  line.usable(3.0);
  for (int k = 0; k < 5000; ++k)
    EXPECT_NE(line.clock.check(line.sent + line.offset - 1.0, line.arrived + kPeriod * k).verdict,
              Verdict::kUsable);
}

TEST(StampClock, WhereEchoesAreAnsweredOnlyTheyCount) {
  Line line;
  const auto echo = [&] {
    const auto number = line.clock.echoes().ask(line.arrived);
    line.clock.echoes().answer(number, line.arrived + line.latency + line.offset,
                               line.arrived + 2.0 * line.latency);
  };
  const auto usable = [&](double seconds) {
    int count = 0;
    for (int k = 0; k < 10.0 * seconds; ++k) {
      echo();
      count += line.usable(0.1);
    }
    return count;
  };
  usable(3.0);
  line.offset -= 0.5;
  usable(2.0);
  EXPECT_GT(usable(1.0), 490);
  EXPECT_NEAR(line.last.age, 2.0 * kOneWay, 1e-9);
  line.latency += 0.5;
  EXPECT_EQ(usable(20.0), 0);
  EXPECT_EQ(line.set, 0);
}

}  // namespace
}  // namespace palpate::test
