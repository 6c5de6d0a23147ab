#include <palpate/servo/worker.h>

#include <atomic>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Tells how often it was called.
struct Counter final : BackgroundWork {
  std::atomic<int> taken = 0, finished = 0;
  void take() override { ++taken; }
  void finish() override { ++finished; }
};

TEST(VirtualWorker, AnAnswerComesADelayAfterItsQuestion) {
  Counter work;
  VirtualWorker worker({&work}, 0.05);
  for (int k = 0; k < 50; ++k) worker.run_until(1e-3 * k);
  EXPECT_EQ(work.taken, 1);
  EXPECT_EQ(work.finished, 0);
  worker.run_until(0.0501);
  EXPECT_EQ(work.finished, 1);
  EXPECT_EQ(work.taken, 2);
}

TEST(VirtualWorker, AnAnswerIsBetweenOneAndTwoRoundsOld) {
  Counter work;
  VirtualWorker worker({&work}, 0.05);
  double oldest = 0.0;
  for (int k = 0; k <= 1000; ++k) {
    worker.run_until(1e-3 * k);
    if (k < 60) continue;
    EXPECT_GE(worker.age(1e-3 * k), 0.05 - 1e-9);
    oldest = std::max(oldest, worker.age(1e-3 * k));
  }
  EXPECT_NEAR(oldest, 0.1, 3e-3);
}

TEST(VirtualWorker, WithoutDelayItAnswersInTheNextTick) {
  Counter work;
  VirtualWorker worker({&work}, 0.0);
  for (int k = 0; k < 10; ++k) worker.run_until(1e-3 * k);
  EXPECT_EQ(work.finished, 9);
}

TEST(WorkerThread, WorksInRounds) {
  const LoopClock clock;
  Counter work;
  {
    const WorkerThread worker({&work}, clock);
    while (work.finished < 5) clock.sleep_until(clock.now() + 1e-3);
    EXPECT_LT(worker.age(clock.now()), clock.now());
  }
  EXPECT_EQ(work.taken, work.finished);  // it ended after a round
}

TEST(WorkerThread, IsAsLateAsItIsTold) {
  const LoopClock clock;
  Counter work;
  const WorkerThread worker({&work}, clock, 0.03);
  while (work.finished < 3) clock.sleep_until(clock.now() + 1e-3);
  EXPECT_GE(clock.now(), 0.09);
}

}  // namespace
}  // namespace palpate
