#include <palpate/servo/clock.h>

#include <cerrno>
#include <cmath>
#include <ctime>

namespace palpate {
namespace {

constexpr double kNanosecond = 1e-9;

}  // namespace

double monotonic_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + kNanosecond * static_cast<double>(now.tv_nsec);
}

void sleep_until(double t) {
  const double whole = std::floor(t);
  timespec until{};
  until.tv_sec = static_cast<std::time_t>(whole);
  until.tv_nsec = static_cast<long>((t - whole) / kNanosecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace palpate
