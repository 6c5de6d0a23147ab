#include "terminal.h"

#include <chrono>
#include <cstdio>
#include <string>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

namespace palpate::cli {
namespace {

/// Returns a descriptor for stderr that does not block. A newly opened description has its own flags, but
/// also its own offset: in a regular file, which blocks nobody, what stdout writes to the same file
/// (`> log 2>&1`) would overwrite its lines. There the description is shared instead.
int nonblocking_stderr() {
  struct stat status {};
  if (::fstat(STDERR_FILENO, &status) == 0 && S_ISREG(status.st_mode))
    return ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  return ::open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | O_APPEND);
}

}  // namespace

NonblockingStderr::NonblockingStderr() : descriptor_(nonblocking_stderr()) {}

NonblockingStderr::~NonblockingStderr() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void NonblockingStderr::write(std::string_view text) const {
  // A socket, such as systemd's journal, cannot be opened anew; MSG_DONTWAIT is used instead.
  const ssize_t written = descriptor_ >= 0
                              ? ::write(descriptor_, text.data(), text.size())
                              : ::send(STDERR_FILENO, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (written < 0) return;  // discarded
}

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
