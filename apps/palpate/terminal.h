/// \file
/// Terminal output while a command runs.
#pragma once

#include <string_view>

#include <palpate/base/progress.h>

namespace palpate::cli {

/// Non-blocking stderr: output that does not fit, on a stopped terminal (Ctrl-S) or a pipe without a reader,
/// is discarded. The flags of the original descriptor, which other processes share, are not changed. A
/// regular file is written at the offset that stdout may share.
class NonblockingStderr {
 public:
  NonblockingStderr();
  ~NonblockingStderr();
  NonblockingStderr(const NonblockingStderr&) = delete;
  NonblockingStderr& operator=(const NonblockingStderr&) = delete;

  void write(std::string_view text) const;

 private:
  int descriptor_;  ///< -1 if it cannot be opened anew
};

/// Opens /dev/null in place of stdin, stdout and stderr if they are closed: a file opened later would
/// otherwise get their descriptor.
void open_closed_streams();

/// A progress bar on stderr, or nothing at all if stderr is not a terminal or `quiet` is set.
Progress terminal_progress(bool quiet);

}  // namespace palpate::cli
