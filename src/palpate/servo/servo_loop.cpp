#include <palpate/servo/servo_loop.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <palpate/base/signal_stack.h>

namespace palpate {
namespace {

/// Weight of the newest age in the mean: a time constant of 20 ms at 1 kHz, short for a hand.
constexpr double kAgeShare = 0.05;

}  // namespace

bool StallFlag::apply(TickRecord& record) const {
  if (!is_set() || record.fault == Fault::kStalled) return false;
  record.state = GovernorState::kStopped;
  record.fault = Fault::kStalled;
  record.sent = record.sent_world = {};
  record.force_scale = 0.0;
  return true;
}

ServoLoop::ServoLoop(ServoTick& tick, const LoopClock& clock, std::vector<TickObserver*> observers,
                     const Options& options)
    : tick_(tick),
      clock_(clock),
      observers_(std::move(observers)),
      watchdog_([this, options] { watch(options); }) {
  // Last, so that no tick has run if the system refuses a thread.
  try {
    thread_ = std::thread([this, options] {
      run(options);
      ended_.store(true, std::memory_order_release);
    });
  } catch (...) {
    end_watchdog();
    throw;
  }
}

ServoLoop::~ServoLoop() { stop(); }

bool ServoLoop::stop(double patience) {
  if (!thread_.joinable()) return true;
  ends_.store(true, std::memory_order_relaxed);
  constexpr double kLook = 1e-3;  // s
  double waited = 0.0;            // by its own waits: a program that was stopped meanwhile has not waited
  for (std::uint64_t seen = 0; !ended_.load(std::memory_order_acquire);) {
    if (waited >= patience) return false;
    sleep_until(monotonic_now() + kLook);
    const std::uint64_t now = statistics_.ticks.load(std::memory_order_relaxed);
    waited = now == std::exchange(seen, now) ? waited + kLook : 0.0;
  }
  thread_.join();
  end_watchdog();
  return true;
}

void ServoLoop::abandon() {
  thread_.detach();
  end_watchdog();
}

void ServoLoop::end_watchdog() {
  over_.store(true, std::memory_order_relaxed);
  watchdog_.join();
}

void ServoLoop::watch(const Options& options) {
  const SignalStack stack;                  // stop() of a driver may overflow the thread's own
  ThreadPriority above = options.priority;  // a busy loop must not keep it from running
  above.priority = std::min(above.priority + 1, 99);
  if (options.real_time) make_real_time(above);
  name_thread("palpate-watch");
  constexpr double kLook = 0.2;  // interval of checks, as a fraction of patience
  const double patience = std::max(kPatience, 3.0 / options.rate);
  std::uint64_t seen = 0;
  double since = clock_.now();
  while (!over_.load(std::memory_order_relaxed)) {
    clock_.sleep_until(clock_.now() + kLook * patience);
    const std::uint64_t now = statistics_.ticks.load(std::memory_order_relaxed);
    if (now != seen) {
      seen = now;
      since = clock_.now();
    } else if (clock_.now() - since > patience) {
      tick_.stall();
      for (TickObserver* observer : observers_) observer->stall();
    }
  }
}

std::vector<std::string> ServoLoop::refused() const {
  begun_.wait(false, std::memory_order_acquire);
  return refused_;
}

void ServoLoop::tick(double due) {
  const double spent = thread_time();  // a system call that is no part of the tick
  const double begin = clock_.now();
  const TickRecord& record = tick_.run(begin);
  TickTimes times;
  times.late = begin - due;
  const double sent = clock_.now();
  times.compute = sent - begin;
  times.age = sent - record.reading.t;
  tick_.count_contacts();
  times.whole = clock_.now() - begin;
  times.spent = thread_time() - spent;
  times.overruns = statistics_.overruns.load(std::memory_order_relaxed);
  statistics_.late.add(times.late);
  statistics_.whole.add(times.whole);
  statistics_.spent.add(times.spent);
  statistics_.age.add(times.age);
  statistics_.ticks.fetch_add(1, std::memory_order_relaxed);
  for (TickObserver* observer : observers_) observer->see(record, times);
  mean_age_ += kAgeShare * (times.age - mean_age_);
  tick_.set_delay(mean_age_);
}

void ServoLoop::run(const Options& options) {
  const SignalStack stack;  // a driver may overflow the thread's own
  if (options.real_time) refused_ = make_real_time(options.priority);
  name_thread("palpate-servo");
  begun_.store(true, std::memory_order_release);
  begun_.notify_all();
  const double period = 1.0 / options.rate;
  double begin = clock_.now();
  std::uint64_t beat = 0;
  for (;;) {
    double due = begin + period * static_cast<double>(beat);
    tick_.wait(clock_, due);
    const double early =
        std::max(0.0, due - clock_.now());  // a reading arrived early: the schedule follows it
    begin -= early;
    due -= early;
    if (ends_.load(std::memory_order_relaxed)) {
      const bool rests = tick_.come_to_rest();
      if (rests && tick_.governor().state() == GovernorState::kStopped) return;
      tick_.governor().stop(Fault::kEnded);
    }
    tick(due);
    const auto next = static_cast<std::uint64_t>(std::floor((clock_.now() - begin) / period)) + 1;
    statistics_.overruns.fetch_add(next > beat + 1 ? next - beat - 1 : 0, std::memory_order_relaxed);
    beat = next;
  }
}

}  // namespace palpate
