#include <palpate/base/clock.h>

#include <cerrno>
#include <cmath>
#include <ctime>

namespace palpate {
namespace {

constexpr double kNanosecond = 1e-9;

double read_clock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + kNanosecond * static_cast<double>(now.tv_nsec);
}

}  // namespace

double monotonic_now() { return read_clock(CLOCK_MONOTONIC); }

double thread_time() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

void sleep_until(double t) {
  const double whole = std::floor(t);
  timespec until{};
  until.tv_sec = static_cast<std::time_t>(whole);
  until.tv_nsec = static_cast<long>((t - whole) / kNanosecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace palpate
