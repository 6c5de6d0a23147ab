#include "terminal.h"

#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

namespace palpate::cli {

void open_closed_streams() {
  for (int descriptor = 0; descriptor < 3; ++descriptor) {
    struct stat status {};
    // open() returns the lowest free descriptor, which is the closed one.
    if (::fstat(descriptor, &status) != 0 && ::open("/dev/null", O_RDWR) != descriptor) return;
  }
}

Progress terminal_progress(bool quiet) {
  if (quiet || ::isatty(STDERR_FILENO) == 0) return {};
  using Clock = std::chrono::steady_clock;
  static constexpr auto kInterval = std::chrono::milliseconds(50);
  static constexpr std::size_t kWidth = 30;
  return [last = Clock::time_point{}](std::string_view stage, double fraction) mutable {
    const auto now = Clock::now();
    if (fraction < 1.0 && now - last < kInterval) return;
    last = now;
    const auto filled = static_cast<std::size_t>(fraction * kWidth);
    fmt::print(stderr, "\r{:<10} [{}{}] {:3.0f} %", stage, std::string(filled, '#'),
               std::string(kWidth - filled, ' '), 100.0 * fraction);
    if (fraction >= 1.0) fmt::print(stderr, "\r\033[K");  // the line belongs to the results again
    std::fflush(stderr);
  };
}

}  // namespace palpate::cli
