#include <palpate/servo/worker.h>

#include <palpate/base/real_time.h>

namespace palpate {
namespace {

/// Pause between two rounds: as often as a servo loop asks, without occupying a core by polling. Unit: [s].
constexpr double kPause = 1e-3;

}  // namespace

void VirtualWorker::run_until(double t) {
  const auto take = [&](double when) {
    for (BackgroundWork* work : work_) work->take();
    taken_ = when;
  };
  if (!started_) {
    started_ = true;
    answered_ = t;
    take(t);
    return;
  }
  // However late, at most one round is new: it takes the latest requests.
  if (t < taken_ + delay_) return;
  for (BackgroundWork* work : work_) work->finish();
  answered_ = taken_;
  take(t);
}

WorkerThread::WorkerThread(std::vector<BackgroundWork*> work, const LoopClock& clock, double delay)
    : work_(std::move(work)), clock_(clock), delay_(delay), answered_(clock.now()), thread_([this] {
        run();
      }) {}

WorkerThread::~WorkerThread() {
  ends_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void WorkerThread::run() {
  name_thread("palpate-worker");
  while (!ends_.load(std::memory_order_relaxed)) {
    const double taken = clock_.now();
    for (BackgroundWork* work : work_) work->take();
    if (delay_ > 0.0) clock_.sleep_until(taken + delay_);
    for (BackgroundWork* work : work_) work->finish();
    answered_.store(taken, std::memory_order_relaxed);
    clock_.sleep_until(clock_.now() + kPause);
  }
}

}  // namespace palpate
