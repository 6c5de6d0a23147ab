#include <palpate/record/spsc_ring.h>

#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(SpscRing, RoundsItsRoomUp) {
  EXPECT_EQ(SpscRing<int>(1).room(), 1U);
  EXPECT_EQ(SpscRing<int>(5).room(), 8U);
  EXPECT_EQ(SpscRing<int>(8).room(), 8U);
}

TEST(SpscRing, TakesWhatFitsAndGivesItBackInOrder) {
  SpscRing<int> ring(4);
  int next = 0, expected = 0;
  for (int round = 0; round < 5; ++round) {  // goes round
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(next++));
    EXPECT_FALSE(ring.push(-1));
    ring.drain([&](int value) { EXPECT_EQ(value, expected++); });
    EXPECT_EQ(expected, next);
    EXPECT_TRUE(ring.push(next++));  // out of step with the slots
    ring.drain([&](int value) { EXPECT_EQ(value, expected++); });
  }
  ring.drain([](int) { FAIL() << "it is empty"; });
}

TEST(SpscRing, PassesEveryValueFromThreadToThread) {
  constexpr std::uint64_t kValues = 200'000;
  struct Pair {
    std::uint64_t value, square;  // two words: half a value would show
  };
  SpscRing<Pair> ring(16);
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < kValues;) {
      if (ring.push({i, i * i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t expected = 0, wrong = 0;
  while (expected < kValues) {
    ring.drain([&](const Pair& pair) {
      wrong += pair.value != expected || pair.square != expected * expected ? 1 : 0;
      ++expected;
    });
    std::this_thread::yield();
  }
  producer.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(expected, kValues);
}

}  // namespace
}  // namespace palpate
