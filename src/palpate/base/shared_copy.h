/// \file
/// A copy of a file in memory, which processes share.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace palpate {

/// The bytes of a file as they were when it was opened: nothing that happens to the file afterwards reaches
/// them, and nobody can change them any more. They are in memory once for all processes of a user that have a
/// copy of the same file: a sealed memfd (F_SEAL_WRITE, F_SEAL_SHRINK, F_SEAL_GROW), which whoever comes
/// later finds through a symbolic link in the folder for such ($XDG_RUNTIME_DIR, else the one for temporary
/// files). What is found there counts only if it is sealed and the user's own. Where there is nothing to be
/// found, or whoever made it has gone, the file is copied once more. Immutable; any thread.
class SharedCopy {
 public:
  /// \throws Error if `path` is missing, unreadable, empty or not a regular file, is cut while it is read, or
  /// there is no memory for it.
  explicit SharedCopy(const std::string& path);
  ~SharedCopy();
  SharedCopy(const SharedCopy&) = delete;
  SharedCopy& operator=(const SharedCopy&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  int descriptor_ = -1;  ///< of the memory, read-only: for those who come later
  std::string link_;     ///< by which they find it, if it was made here
  std::span<const std::byte> bytes_;
};

}  // namespace palpate
