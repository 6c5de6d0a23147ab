#include <palpate/base/triple_buffer.h>

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(TripleBuffer, ThereIsNothingNewUntilSomethingIsPublished) {
  TripleBuffer<int> value;
  EXPECT_FALSE(value.update());
  value.back() = 1;
  EXPECT_FALSE(value.update());
  value.publish();
  EXPECT_TRUE(value.update());
  EXPECT_EQ(value.front(), 1);
  EXPECT_FALSE(value.update());
  EXPECT_EQ(value.front(), 1);
}

TEST(TripleBuffer, TheReaderSeesTheNewest) {
  TripleBuffer<int> value;
  for (int k = 1; k <= 5; ++k) {
    value.back() = k;
    value.publish();
  }
  EXPECT_TRUE(value.update());
  EXPECT_EQ(value.front(), 5);
  EXPECT_FALSE(value.update());
}

TEST(TripleBuffer, WhatTheReaderHoldsIsNotWrittenTo) {
  TripleBuffer<int> value;
  value.back() = 1;
  value.publish();
  value.update();
  for (int k = 2; k < 20; ++k) {
    value.back() = k;
    value.publish();
    EXPECT_EQ(value.front(), 1);
  }
}

// Two threads: no value is torn, none comes after a later one, and the last arrives.
TEST(TripleBuffer, GoesFromThreadToThread) {
  struct Pair {
    long a = 0, b = 0;
  };
  constexpr long kLast = 200000;
  TripleBuffer<Pair> value;
  std::thread writer([&] {
    for (long k = 1; k <= kLast; ++k) {
      value.back() = {k, -k};
      value.publish();
    }
  });
  long seen = 0;
  while (seen < kLast) {
    if (!value.update()) continue;
    ASSERT_EQ(value.front().a, -value.front().b);
    ASSERT_GT(value.front().a, seen);
    seen = value.front().a;
  }
  writer.join();
}

}  // namespace
}  // namespace palpate
