/// \file
/// What runs BackgroundWork beside the servo loop.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include <palpate/base/background_work.h>
#include <palpate/base/clock.h>

namespace palpate {

/// Does its work in rounds, again and again: takes what is wanted, takes its time, hands the answer over.
class Worker {
 public:
  virtual ~Worker() = default;

  /// How long ago the newest answer was asked for: what the watchdog looks at. Any thread. \param t now, on
  /// the loop's clock. Unit: [s]. \returns Unit: [s].
  virtual double age(double t) const = 0;
};

/// A worker in virtual time, each of whose rounds takes exactly `delay`.
class VirtualWorker final : public Worker {
 public:
  /// `work` must outlive it. \param delay Unit: [s]. >= 0
  VirtualWorker(std::vector<BackgroundWork*> work, double delay) : work_(std::move(work)), delay_(delay) {}

  /// All that happens until `t`. \param t never falls. Unit: [s].
  void run_until(double t);

  double age(double t) const override { return t - answered_; }

 private:
  std::vector<BackgroundWork*> work_;
  double delay_;
  bool started_ = false;
  double taken_ = 0.0, answered_ = 0.0;  ///< when the questions of this round and of the newest answer were
                                         ///< taken. Unit: [s].
};

/// A worker on a thread of its own, of ordinary priority.
class WorkerThread final : public Worker {
 public:
  /// Begins. `work` must outlive it. \param delay that every round takes longer than it must, to see what
  /// comes of it. Unit: [s].
  WorkerThread(std::vector<BackgroundWork*> work, const LoopClock& clock, double delay = 0.0);
  /// Waits for the round that is under way.
  ~WorkerThread() override;
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  double age(double t) const override { return t - answered_.load(std::memory_order_relaxed); }

 private:
  void run();

  std::vector<BackgroundWork*> work_;
  LoopClock clock_;
  double delay_;
  std::atomic<bool> ends_ = false;
  std::atomic<double> answered_;
  std::thread thread_;
};

}  // namespace palpate
