// What wakes a thread: at once where it is set, and after the time that was given where it is not.
#include <palpate/rosbridge/wake.h>

#include <atomic>
#include <thread>

#include <gtest/gtest.h>
#include <poll.h>

#include <palpate/base/clock.h>

namespace palpate {
namespace {

bool is_readable(const Wake& wake) {
  pollfd watched{wake.descriptor(), POLLIN, 0};
  return ::poll(&watched, 1, 0) == 1;
}

TEST(Wake, IsReadableWhileItIsSet) {
  Wake wake;
  EXPECT_FALSE(is_readable(wake));
  wake.set();
  wake.set();
  EXPECT_TRUE(is_readable(wake));
  wake.clear();
  EXPECT_FALSE(is_readable(wake));
  wake.clear();  // once more does no harm
}

// Whole seconds and what is over them are two numbers for the system.
TEST(Wake, WaitsForTheTimeThatIsGiven) {
  Wake wake;
  for (const double seconds : {0.02, 1.05}) {
    const double begin = monotonic_now();
    wake.wait(seconds);
    EXPECT_GE(monotonic_now() - begin, seconds - 1e-3);
  }
  wake.wait(0.0);
  wake.wait(-1.0);
}

TEST(Wake, WhatWasSetBeforeCountsAndIsTakenBack) {
  constexpr double kForEver = 3600.0;
  Wake wake;
  wake.set();
  wake.wait(kForEver);
  EXPECT_FALSE(is_readable(wake));
  wake.set();
  wake.wait(0.0);
  EXPECT_FALSE(is_readable(wake)) << "without waiting, too";
}

TEST(Wake, IsSetFromAnotherThread) {
  constexpr double kForEver = 3600.0;
  Wake wake;
  std::atomic<int> told = 0;
  std::thread other([&] {
    told = 1;
    wake.set();
  });
  wake.wait(kForEver);
  EXPECT_EQ(told, 1);
  other.join();
}

}  // namespace
}  // namespace palpate
