/// \file
/// A file that can be read while it is written, and after its writer was killed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

/// A new file of lines that grows in place. What append() has taken is seen by every reader at once and stays
/// when the process is killed at any instant, which cuts one line at most. (What must appear whole or not at
/// all is an OutputFile.) It need not survive the death of the machine before finish(). Used by one thread at
/// a time.
class GrowingFile {
 public:
  /// \param lines go in first. \throws Error if `path` exists, its folder is missing or cannot be written, or
  /// the disk is full; there is no new file then.
  GrowingFile(std::string path, std::string_view lines);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  const std::string& path() const { return path_; }

  /// Hands whole lines to the system. \throws Error when the disk is full or fails; the file then ends with
  /// the last whole line that went in, and size() tells where that is.
  void append(std::string_view lines);

  /// Of the lines that are in it. Unit: [bytes].
  std::uint64_t size() const { return size_; }

  /// Waits until all is on the disk, which may take seconds, and closes the file; nothing can be appended
  /// then. \throws Error when the disk fails.
  void finish();

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace palpate
