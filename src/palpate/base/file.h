/// \file
/// Input and output files with complete error checking and atomic replacement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// Regular file open for reading at any offset. Move-only. Any number of threads may read concurrently.
class InputFile {
 public:
  /// \throws Error if `path` is missing, unreadable or not a regular file.
  explicit InputFile(const std::string& path);
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;

  const std::string& path() const { return path_; }
  /// Size in bytes when the file was opened.
  std::uint64_t size() const { return size_; }

  /// Fills `out` from byte `offset`; returns the bytes read, fewer only at the end of the file.
  /// \throws Error when the read fails.
  std::size_t read_some(std::uint64_t offset, std::span<char> out) const;

  /// Fills all of `out` from byte `offset`. \throws Error when the read fails or the file ends early (it was
  /// truncated in the meantime).
  void read(std::uint64_t offset, std::span<char> out) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// \throws Error "PATH: cannot ACTION: REASON", with a remedy for the user, for a system call that failed.
/// \param error_number errno
[[noreturn]] void throw_file_error(const std::string& path, std::string_view action, int error_number);

/// \throws Error if the name of an output file is "-", which other programs take for standard output.
void refuse_dash(const std::string& path);

/// The contents of a text file of at most `max_bytes`. \throws Error if it is larger or unreadable.
std::string read_text_file(const std::string& path, std::uint64_t max_bytes);

/// File that is written atomically: bytes go to an unnamed file in the target's folder, which takes the
/// target's name in commit(). Without a commit (an exception, a kill) nothing is left behind and an existing
/// file of that name is untouched; after a commit, the new file has the mode of the one it replaced. Symbolic
/// links are followed. A target that exists and is not a regular file (a pipe, /dev/stdout) is written to
/// directly.
class OutputFile {
 public:
  /// \throws Error if the folder is missing or cannot be written.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends `bytes`. \throws Error when the disk is full or the write fails.
  void write(std::string_view bytes);

  /// Whether commit() waits until the data is on disk. A file that can be regenerated at any time and is
  /// validated when read need not wait.
  enum class Sync { kYes, kNo };

  /// Gives the file its name. \throws Error on failure; the target is then unchanged.
  void commit(Sync sync = Sync::kYes);

 private:
  void flush();
  void write_through(std::string_view bytes);
  [[noreturn]] void fail(std::string_view action, int error_number) const;

  std::string path_;       ///< as the user gave it, for messages
  std::string folder_;     ///< of the target
  std::string target_;     ///< with symbolic links resolved
  std::string temporary_;  ///< name to unlink if not committed; empty for an unnamed file
  std::string buffer_;
  int descriptor_ = -1;
  bool direct_ = false;  ///< the target is a pipe or a device
};

/// Unnamed temporary file for data that does not fit memory. Deleted with the object or when the process
/// ends.
class TemporaryFile {
 public:
  /// Creates the file in `folder`. \throws Error if that is not writable.
  explicit TemporaryFile(std::string folder);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Writes bytes at `offset`. \throws Error when the disk is full or fails.
  void write(std::uint64_t offset, std::span<const char> bytes);
  void read(std::uint64_t offset, std::span<char> out) const;

 private:
  std::string folder_;
  int descriptor_ = -1;
};

/// Size and timestamps of a file, to detect that it has changed.
struct FileStamp {
  std::uint64_t size = 0;
  std::int64_t modified_ns = 0;  ///< mtime
  std::int64_t changed_ns = 0;   ///< ctime, which cannot be set back

  bool operator==(const FileStamp&) const = default;
};

/// \throws Error if there is no such file.
FileStamp stamp_of(const std::string& path);

/// True if a file can be created in the folder of `path`. A folder whose permissions allow nobody to write
/// counts as not writable even for a superuser, whom permissions do not restrict.
bool folder_is_writable(const std::string& path);

/// Writes `bytes` atomically, as an OutputFile.
void write_file(const std::string& path, std::string_view bytes);

/// True if both paths exist and name the same file (so that writing one would destroy the other).
bool same_file(const std::string& a, const std::string& b);

}  // namespace palpate
