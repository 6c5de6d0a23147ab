/// \file
/// Append-only text file that can be read while it is written, and after its writer was killed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

/// New file that grows in place, line by line. Appended lines are visible to every reader immediately and
/// survive a kill of the process at any instant, which truncates at most one line. (For a file that must
/// appear atomically, use OutputFile.) Survival of a machine crash is guaranteed only after finish(). One
/// thread at a time.
class GrowingFile {
 public:
  /// \param lines the first content. \throws Error if `path` exists, its folder is missing or not writable,
  /// or the disk is full; no new file is left then.
  GrowingFile(std::string path, std::string_view lines);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  const std::string& path() const { return path_; }

  /// Appends whole lines. \throws Error when the disk is full or fails; the file then ends with the last
  /// whole line written, and size() is the offset of its end. \throws Error, and appends nothing, if the file
  /// has been removed.
  void append(std::string_view lines);

  /// Size of the lines written. Unit: [bytes].
  std::uint64_t size() const { return size_; }

  /// Waits until all data is on disk, which may take seconds, and closes the file; nothing can be appended
  /// afterwards. \throws Error when the disk fails, or if the file is no longer at path().
  void finish();

 private:
  bool is_at_path() const;
  /// \throws Error if no name refers to the file any more.
  void require_a_name() const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace palpate
