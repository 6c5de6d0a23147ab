/// \file
/// Access to a scene's file with detection of later changes.
#pragma once

#include <memory>
#include <string>

#include <sys/stat.h>

#include <palpate/base/file.h>

namespace palpate {

/// Holds a scene's file as it was when opened, and detects whether the file has changed since. Immutable; any
/// thread.
class SceneFile {
 public:
  /// \throws Error if it cannot be read.
  explicit SceneFile(const std::string& path);

  const std::shared_ptr<const InputFile>& bytes() const { return bytes_; }
  /// Returns the entity tag of this version of the file, for caches.
  const std::string& tag() const { return tag_; }

  enum class Change {
    kNone,
    kReplaced,    ///< the name refers to another file, or none; bytes() are the old ones
    kOverwritten  ///< the same file was written to: bytes() may be anything
  };
  /// Checks for a change. May block on a disk.
  Change change() const;

 private:
  std::shared_ptr<const InputFile> bytes_;
  struct stat opened_ {};
  std::string tag_;
};

/// Returns the notice for the user; empty for kNone.
std::string notice_of(SceneFile::Change change);

}  // namespace palpate
