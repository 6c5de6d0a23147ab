#include <palpate/gateway/client_clock.h>

#include <cmath>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kAhead = 1.7e9;  // s, of the client's clock

TEST(ClientClockTest, KnowsNothingBeforeAnEchoIsBack) {
  ClientClock clock;
  EXPECT_FALSE(clock.age(kAhead, 1.0));
  const auto number = clock.ask(1.0);
  EXPECT_FALSE(clock.age(kAhead, 1.0));
  clock.answer(number + 1, kAhead, 1.1);
  clock.answer(0, kAhead, 1.1);
  EXPECT_FALSE(clock.age(kAhead, 1.2)) << "nobody asked for that";
}

// 10 ms there and 30 ms back: a pose measured at 5 and 30 ms under way is 30 ms old, and its answer comes 10
// ms later.
TEST(ClientClockTest, AgeIsThatOfAPoseWhenItsAnswerIsThere) {
  ClientClock clock;
  clock.answer(clock.ask(1.0), kAhead + 1.01, 1.04);
  ASSERT_TRUE(clock.age(kAhead + 5.0, 5.03));
  EXPECT_NEAR(*clock.age(kAhead + 5.0, 5.03), 0.03 + 0.01, 1e-6);
  EXPECT_NEAR(clock.round_trip(), 0.04, 1e-12);
}

TEST(ClientClockTest, TheShortestRoundTripCounts) {
  ClientClock clock;
  clock.answer(clock.ask(1.0), kAhead + 1.001, 1.002);
  clock.answer(clock.ask(2.0), kAhead + 2.4, 2.5);  // it took its time
  EXPECT_NEAR(*clock.age(kAhead + 3.0, 3.001), 0.002, 1e-6);
}

TEST(ClientClockTest, AnAnswerCountsOnce) {
  ClientClock clock;
  const auto number = clock.ask(1.0);
  clock.answer(number, kAhead + 1.0, 1.002);
  clock.answer(number, kAhead + 9.0, 1.002);
  EXPECT_NEAR(*clock.age(kAhead + 1.5, 1.5), 0.0, 1e-6);
}

TEST(ClientClockTest, ForgetsEchoesOfLongAgo) {
  ClientClock clock;
  clock.answer(clock.ask(1.0), kAhead + 1.0, 1.002);
  for (std::size_t k = 0; k < ClientClock::kKept; ++k) {  // the client's clock was set meanwhile
    const double t = 2.0 + 0.1 * static_cast<double>(k);
    clock.answer(clock.ask(t), t + 7.0, t + 0.01);
  }
  EXPECT_NEAR(*clock.age(4.0 + 7.0, 4.0), 0.0, 1e-6);
  EXPECT_FALSE(clock.age(20.0 + 7.0, 20.0)) << "nothing is known any longer";
}

}  // namespace
}  // namespace palpate
