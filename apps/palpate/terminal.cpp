#include "terminal.h"

#include <chrono>
#include <cstdio>
#include <string>

#include <fmt/core.h>
#include <unistd.h>

namespace palpate::cli {

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
