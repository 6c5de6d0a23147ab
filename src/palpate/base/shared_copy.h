/// \file
/// In-memory copy of a file, shared between processes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace palpate {

/// Immutable snapshot of a file's bytes, taken when it was opened: later changes to the file do not affect
/// it, and nothing can modify it. All processes of a user that copy the same file share one instance in
/// memory: a sealed memfd (F_SEAL_WRITE, F_SEAL_SHRINK, F_SEAL_GROW), which later processes find through a
/// symbolic link in the runtime folder ($XDG_RUNTIME_DIR, else the one for temporary files). A memfd found
/// there is used only if it is sealed and owned by the same user. If none is found, or the process that made
/// it has exited, the file is copied again. Any thread.
class SharedCopy {
 public:
  /// \throws Error if `path` is missing, unreadable, empty or not a regular file, is truncated while it is
  /// read, or there is not enough memory for it.
  explicit SharedCopy(const std::string& path);
  ~SharedCopy();
  SharedCopy(const SharedCopy&) = delete;
  SharedCopy& operator=(const SharedCopy&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  int descriptor_ = -1;  ///< of the memory, read-only: for later processes
  std::string link_;     ///< by which they find it, if created by this process
  std::span<const std::byte> bytes_;
};

}  // namespace palpate
