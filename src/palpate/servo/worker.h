/// \file
/// Workers that run BackgroundWork beside the servo loop.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include <palpate/base/background_work.h>
#include <palpate/base/clock.h>

namespace palpate {

/// Repeats its work in rounds: takes a request, computes, hands the result over.
class Worker {
 public:
  virtual ~Worker() = default;

  /// Staleness: time since the newest result was requested, checked by the watchdog. Any thread. \param t
  /// now, on the loop's clock. Unit: [s]. \returns Unit: [s].
  virtual double age(double t) const = 0;
};

/// A worker in virtual time whose rounds take exactly `delay` each.
class VirtualWorker final : public Worker {
 public:
  /// `work` must outlive it. \param delay Unit: [s]. >= 0
  VirtualWorker(std::vector<BackgroundWork*> work, double delay) : work_(std::move(work)), delay_(delay) {}

  /// Finishes the current round if it is over at `t`, and starts the next. \param t never decreases. Unit:
  /// [s].
  void run_until(double t);

  double age(double t) const override { return t - answered_; }

 private:
  std::vector<BackgroundWork*> work_;
  double delay_;
  bool started_ = false;
  double taken_ = 0.0,
         answered_ =
             0.0;  ///< when the requests of this round and of the newest result were taken. Unit: [s].
};

/// A worker on a thread of its own, of ordinary priority.
class WorkerThread final : public Worker {
 public:
  /// Starts the thread. `work` must outlive it. \param delay added to every round, for experiments. Unit:
  /// [s].
  WorkerThread(std::vector<BackgroundWork*> work, const LoopClock& clock, double delay = 0.0);
  /// Waits for the current round.
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
