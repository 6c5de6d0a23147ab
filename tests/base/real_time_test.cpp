#include <palpate/base/real_time.h>

#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

namespace palpate {
namespace {

struct Scheduling {
  int policy = 0;
  int priority = 0;
};

Scheduling scheduling_of_this_thread() {
  Scheduling out;
  sched_param parameters{};
  pthread_getschedparam(pthread_self(), &out.policy, &parameters);
  out.priority = parameters.sched_priority;
  return out;
}

TEST(CallRealTime, ThreadsThatTheWorkStartsInheritTheSchedulingAndTheCallerKeepsItsOwn) {
  bool permitted = false;
  std::thread([&] { permitted = make_real_time(kNetworkPriority).empty(); }).join();
  if (!permitted) GTEST_SKIP() << "real-time priority is not permitted here";
  const Scheduling before = scheduling_of_this_thread();
  Scheduling inherited;
  call_real_time(kNetworkPriority,
                 [&] { std::thread([&] { inherited = scheduling_of_this_thread(); }).join(); });
  EXPECT_EQ(inherited.policy, SCHED_FIFO);
  EXPECT_EQ(inherited.priority, kNetworkPriority.priority);
  EXPECT_LT(inherited.priority, ThreadPriority().priority) << "below the servo loop";
  const Scheduling after = scheduling_of_this_thread();
  EXPECT_EQ(after.policy, before.policy);
  EXPECT_EQ(after.priority, before.priority);
}

TEST(CallRealTime, PassesOnWhatTheWorkThrows) {
  EXPECT_THROW(call_real_time(kNetworkPriority, [] { throw std::runtime_error("refused"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace palpate
