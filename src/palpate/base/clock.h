/// \file
/// The clock of everything that is live.
#pragma once

namespace palpate {

/// Seconds on a clock that never jumps or goes back, from an arbitrary beginning. Any thread; no system call
/// where the kernel can help it.
double monotonic_now();

/// What the calling thread has spent of a processor's time: where the machine stops for a while, this does
/// not go on. Unit: [s].
double thread_time();

/// Sleeps until monotonic_now() is `t`, or a little later.
void sleep_until(double t);

/// The time of one loop: 0 where it began. Any thread.
class LoopClock {
 public:
  double now() const { return monotonic_now() - begin_; }
  void sleep_until(double t) const { palpate::sleep_until(begin_ + t); }

 private:
  double begin_ = monotonic_now();
};

}  // namespace palpate
