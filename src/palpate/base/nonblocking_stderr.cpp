#include <palpate/base/nonblocking_stderr.h>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

namespace palpate {
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

void write_to_stderr(std::string_view text) {
  static const NonblockingStderr opened;
  opened.write(text);
}

}  // namespace palpate
