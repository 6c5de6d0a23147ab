#include <palpate/live/scene_file.h>

#include <cerrno>

#include <fmt/format.h>

namespace palpate {

SceneFile::SceneFile(const std::string& path) : bytes_(std::make_shared<const InputFile>(path)) {
  if (::stat(path.c_str(), &opened_) != 0) throw_file_error(path, "read its attributes", errno);
  tag_ = fmt::format("{:x}-{:x}-{:x}", bytes_->size(), opened_.st_mtim.tv_sec, opened_.st_mtim.tv_nsec);
}

SceneFile::Change SceneFile::change() const {
  struct stat now {};
  const bool there = ::stat(bytes_->path().c_str(), &now) == 0;
  if (!there || now.st_dev != opened_.st_dev || now.st_ino != opened_.st_ino) return Change::kReplaced;
  const bool same = now.st_size == opened_.st_size && now.st_mtim.tv_sec == opened_.st_mtim.tv_sec &&
                    now.st_mtim.tv_nsec == opened_.st_mtim.tv_nsec;
  return same ? Change::kNone : Change::kOverwritten;
}

std::string notice_of(SceneFile::Change change) {
  switch (change) {
    case SceneFile::Change::kReplaced:
      return "the scene's file has been replaced since it was opened; the old version is still in use; "
             "restart to load the new one";
    case SceneFile::Change::kOverwritten:
      return "the scene's file has been overwritten since it was opened; forces use the old version, which "
             "cannot be displayed any more; restart to load the new one";
    default: return {};
  }
}

}  // namespace palpate
