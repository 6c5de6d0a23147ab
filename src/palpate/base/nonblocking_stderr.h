/// \file
/// Output to stderr that never waits for a reader.
#pragma once

#include <string_view>

namespace palpate {

/// Non-blocking stderr: output that does not fit, on a stopped terminal (Ctrl-S) or a pipe without a reader,
/// is discarded. The flags of the original descriptor, which other processes share, are not changed. A
/// regular file is written at the offset that stdout may share. Any thread.
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

/// Writes `text` to a NonblockingStderr that is opened by the first call. Any thread.
void write_to_stderr(std::string_view text);

}  // namespace palpate
