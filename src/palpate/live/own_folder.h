/// \file
/// Temporary folder of this process. Internal to live/.
#pragma once

#include <filesystem>
#include <string>

namespace palpate {

/// A folder in the system's temporary folder, removed with all it contains when this object ends.
class OwnFolder {
 public:
  /// \param name first part of the folder's name \throws Error if it cannot be made.
  explicit OwnFolder(const std::string& name);
  ~OwnFolder();
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace palpate
