/// \file
/// A file as memory.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace palpate {

/// A regular file mapped for reading, whole. Its pages are shared with every process that maps it, are read
/// when they are first touched, and take no memory that the system could not have back. The file must not be
/// cut while it is mapped; who replaces it should rename another over it. Immutable; any thread.
class MappedFile {
 public:
  /// \throws Error if `path` is missing, unreadable, empty or not a regular file.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::string& path() const { return path_; }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::string path_;
  std::span<const std::byte> bytes_;
};

}  // namespace palpate
