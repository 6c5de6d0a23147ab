/// \file
/// Reading and writing files so that nothing is half-read, half-written or silently lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// A regular file open for reading at any offset. Move-only. Any number of threads may read at once.
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

  /// Fills all of `out` from byte `offset`.
  /// \throws Error when the read fails or the file ends early (it shrank while it was read).
  void read(std::uint64_t offset, std::span<char> out) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// \throws Error "PATH: cannot ACTION: REASON", and what a person can do about it, for a system call that
/// failed. \param error_number errno
[[noreturn]] void throw_file_error(const std::string& path, std::string_view action, int error_number);

/// The whole of a text file of at most `max_bytes`. \throws Error if it is larger or unreadable.
std::string read_text_file(const std::string& path, std::uint64_t max_bytes);

/// A file that appears whole or not at all: bytes go to an unnamed file in the target's folder,
/// which takes the target's name in commit(). Without a commit (an exception, a kill) nothing is
/// left behind and an earlier file of that name is untouched; after one, the new file has the earlier one's
/// mode. A symbolic link is followed. A target that exists and is not a regular file (a pipe, /dev/stdout) is
/// written through directly.
class OutputFile {
 public:
  /// \throws Error if the folder is missing or cannot be written.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends `bytes`. \throws Error when the disk is full or the write fails.
  void write(std::string_view bytes);

  /// Whether commit() waits until the bytes are on the disk. What can be made again at any time, and is
  /// checked when it is read, need not wait.
  enum class Sync { kYes, kNo };

  /// Gives the file its name. \throws Error on failure; the target is then as it was before.
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

/// A file without a name, for what does not fit memory. Gone with the object, or with the process.
class TemporaryFile {
 public:
  /// In `folder`. \throws Error if that cannot be written.
  explicit TemporaryFile(std::string folder);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Bytes at `offset`. \throws Error when the disk is full or fails.
  void write(std::uint64_t offset, std::span<const char> bytes);
  void read(std::uint64_t offset, std::span<char> out) const;

 private:
  std::string folder_;
  int descriptor_ = -1;
};

/// What tells that a file is not the one that was seen before.
struct FileStamp {
  std::uint64_t size = 0;
  std::int64_t modified_ns = 0;  ///< mtime
  std::int64_t changed_ns = 0;   ///< ctime, which nobody can set back

  bool operator==(const FileStamp&) const = default;
};

/// \throws Error if there is no such file.
FileStamp stamp_of(const std::string& path);

/// True if a file could be made in the folder of `path`. A folder that its permissions let nobody write to is
/// left alone, also by a superuser, whom they do not bind.
bool folder_is_writable(const std::string& path);

/// Writes `bytes` as an OutputFile in one go.
void write_file(const std::string& path, std::string_view bytes);

/// True if both paths exist and are one file (so that writing one would destroy the other).
bool same_file(const std::string& a, const std::string& b);

}  // namespace palpate
