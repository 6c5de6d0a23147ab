/// \file
/// A file as memory.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <palpate/base/shared_copy.h>

namespace palpate {

/// Whose memory a file's bytes are in.
enum class FileMemory {
  /// Shared with every process that maps the file: pages are read when they are first touched, and take no
  /// memory that the system could not have back. The file must not be cut or written to meanwhile: touching
  /// a page that is gone raises SIGBUS. Who replaces it should rename another over it.
  kShared,
  kOwn,  ///< a SharedCopy: nothing that happens to the file afterwards reaches it
};

/// A regular file as memory, for reading, whole. Immutable; any thread.
class MappedFile {
 public:
  /// \throws Error if `path` is missing, unreadable, empty or not a regular file; or, for a copy, if there is
  /// no memory for it, or it is cut while it is read.
  explicit MappedFile(const std::string& path, FileMemory memory = FileMemory::kShared);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::string& path() const { return path_; }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::string path_;
  std::optional<SharedCopy> copy_;  ///< none: it is a map
  std::span<const std::byte> bytes_;
};

}  // namespace palpate
