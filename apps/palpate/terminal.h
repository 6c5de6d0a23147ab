/// \file
/// Terminal output while a command runs.
#pragma once

#include <string_view>

#include <palpate/base/progress.h>

namespace palpate::cli {

/// stderr, written to without waiting: what does not fit, on a terminal that is held (Ctrl-S) or a pipe that
/// nobody reads, is lost. The descriptor itself stays as it is, which other processes share.
class NonblockingStderr {
 public:
  NonblockingStderr();
  ~NonblockingStderr();
  NonblockingStderr(const NonblockingStderr&) = delete;
  NonblockingStderr& operator=(const NonblockingStderr&) = delete;

  void write(std::string_view text) const;

 private:
  int descriptor_;  ///< -1: there is none
};

/// Opens /dev/null in place of stdin, stdout and stderr where they are closed: a file that is opened later
/// would be taken for one of them.
void open_closed_streams();

/// A progress bar on stderr, or nothing at all if stderr is not a terminal or `quiet` is set.
Progress terminal_progress(bool quiet);

}  // namespace palpate::cli
