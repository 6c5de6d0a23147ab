/// \file
/// The file of a scene while somebody looks at it.
#pragma once

#include <memory>
#include <string>

#include <sys/stat.h>

#include <palpate/base/file.h>

namespace palpate {

/// Serves a scene's file as it was when it was opened, and notices where it is another by now. Immutable; any
/// thread.
class SceneFile {
 public:
  /// \throws Error if it cannot be read.
  explicit SceneFile(const std::string& path);

  const std::shared_ptr<const InputFile>& bytes() const { return bytes_; }
  /// Of this file at this time, for caches.
  const std::string& tag() const { return tag_; }

  enum class Change {
    kNone,
    kReplaced,    ///< there is another of that name, or none; bytes() are the old ones
    kOverwritten  ///< it is the same and has been written to: bytes() may be anything
  };
  /// May wait for a disk.
  Change change() const;

 private:
  std::shared_ptr<const InputFile> bytes_;
  struct stat opened_ {};
  std::string tag_;
};

/// For a person; empty for none.
std::string notice_of(SceneFile::Change change);

}  // namespace palpate
