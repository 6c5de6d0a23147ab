// A terminal that nobody reads.
#include <palpate/base/nonblocking_stderr.h>

#include <cerrno>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

/// Both ends of a channel. Its `in` is stderr as long as this exists.
class StderrInto {
 public:
  explicit StderrInto(bool is_socket) : before_(::dup(STDERR_FILENO)) {
    int ends[2];
    EXPECT_EQ(is_socket ? ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) : ::pipe(ends), 0);
    out = ends[0];
    in = ends[1];
    ::dup2(in, STDERR_FILENO);
  }
  ~StderrInto() {
    ::dup2(before_, STDERR_FILENO);
    for (const int end : {out, in, before_}) ::close(end);
  }
  StderrInto(const StderrInto&) = delete;
  StderrInto& operator=(const StderrInto&) = delete;

  /// All that is in it.
  std::string read() const {
    std::string all;
    char some[4096];
    ::fcntl(out, F_SETFL, O_NONBLOCK);
    for (ssize_t size = 0; (size = ::read(out, some, sizeof some)) > 0;) all.append(some, size);
    return all;
  }

  int out = -1, in = -1;

 private:
  int before_;
};

TEST(NonblockingStderr, GoesOnWhereNobodyReads) {
  for (const bool is_socket : {false, true}) {
    const StderrInto channel(is_socket);
    const NonblockingStderr terminal;
    const std::string line(1000, 'x');
    for (int k = 0; k < 2000; ++k) terminal.write(line);  // a megabyte and more, of which it holds a part
    const std::string held = channel.read();
    EXPECT_GT(held.size(), 10 * line.size());
    EXPECT_LT(held.size(), 1000 * line.size());
    terminal.write("is read again\n");
    EXPECT_EQ(channel.read(), "is read again\n");
    EXPECT_EQ(::fcntl(channel.in, F_GETFL) & O_NONBLOCK, 0) << "others who share it still wait";
  }
}

}  // namespace
}  // namespace palpate
