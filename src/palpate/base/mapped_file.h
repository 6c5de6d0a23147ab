/// \file
/// Memory-mapped file.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <palpate/base/shared_copy.h>

namespace palpate {

/// Storage of the bytes of a mapped file.
enum class FileMemory {
  /// Shared with every process that maps the file: pages are read on first access, and the system can reclaim
  /// their memory. The file must not be truncated or written to meanwhile: accessing a page that is gone
  /// raises SIGBUS. To replace it, rename another file over it.
  kShared,
  kOwn,  ///< a SharedCopy: unaffected by later changes to the file
};

/// A whole regular file as read-only memory. Immutable; any thread.
class MappedFile {
 public:
  /// \throws Error if `path` is missing, unreadable, empty or not a regular file; or, for a copy, if there is
  /// not enough memory, or the file is truncated while it is read.
  explicit MappedFile(const std::string& path, FileMemory memory = FileMemory::kShared);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::string& path() const { return path_; }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::string path_;
  std::optional<SharedCopy> copy_;  ///< unset: the file is mapped
  std::span<const std::byte> bytes_;
};

}  // namespace palpate
