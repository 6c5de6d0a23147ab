#include <palpate/live/own_folder.h>

#include <cerrno>
#include <system_error>

#include <stdlib.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate {

OwnFolder::OwnFolder(const std::string& name) {
  std::string pattern = (std::filesystem::temp_directory_path() / (name + "-XXXXXX")).string();
  if (::mkdtemp(pattern.data()) == nullptr) throw_file_error(pattern, "make", errno);
  path_ = pattern;
}

OwnFolder::~OwnFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace palpate
