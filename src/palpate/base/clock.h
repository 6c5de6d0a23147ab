/// \file
/// Monotonic clock of all live loops.
#pragma once

namespace palpate {

/// Seconds on a monotonic clock with an arbitrary origin. Any thread; no system call where the kernel
/// supports that.
double monotonic_now();

/// Processor time consumed by the calling thread; it does not advance while the machine stalls. Unit: [s].
double thread_time();

/// Sleeps until monotonic_now() is `t` or slightly later.
void sleep_until(double t);

/// Time since the start of one loop, 0 at its start. Any thread.
class LoopClock {
 public:
  double now() const { return monotonic_now() - begin_; }
  void sleep_until(double t) const { palpate::sleep_until(begin_ + t); }

 private:
  double begin_ = monotonic_now();
};

}  // namespace palpate
