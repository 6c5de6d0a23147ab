#include <palpate/live/drawn_scene.h>

#include <exception>
#include <filesystem>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/live/live_scene.h>
#include <palpate/live/own_folder.h>
#include <palpate/scene/drawable_ply.h>
#include <palpate/scene/ply_writer.h>

namespace palpate {

DrawnScene::DrawnScene(const SceneConfig& scene) : path_(scene.path) {
  if (path_.empty()) {
    bytes_ = ply_bytes(built_in_scene().scene, "palpate: " + scene.name());
    return;
  }
  file_ = std::make_unique<SceneFile>(path_);
  needs_copy_ = !is_drawable(path_);
}

/// Returns the copy, whose name is removed at once: it goes with the last reference.
std::shared_ptr<const InputFile> DrawnScene::copied() const {
  const OwnFolder folder("palpate-drawn");
  const std::uint64_t free = std::filesystem::space(folder.path()).available;
  if (const std::uint64_t bytes = drawable_ply_bytes(path_); free < kRoom || free - kRoom < bytes)
    throw Error("not enough disk space in {} for a copy that can be displayed ({} MB)",
                folder.path().parent_path().string(), bytes >> 20U);
  const std::string name = (folder.path() / "scene.ply").string();
  write_drawable_ply(path_, name);
  if (const auto change = file_->change(); change != SceneFile::Change::kNone)
    throw Error("{}", notice_of(change));
  return std::make_shared<const InputFile>(name);
}

void DrawnScene::make_copy() {
  std::shared_ptr<const InputFile> copy;
  std::string failure;
  try {
    copy = copied();
  } catch (const std::exception& error) {
    failure = error.what();
  }
  const std::scoped_lock lock(mutex_);
  copy_ = std::move(copy);
  failure_ = std::move(failure);
}

DrawnScene::Served DrawnScene::served() const {
  if (!file_) return {bytes_, nullptr, tag(), false, {}};
  const SceneFile::Change change = file_->change();
  const std::scoped_lock lock(mutex_);
  if (copy_) return {{}, copy_, tag() + "-drawn", false, {}};
  if (!failure_.empty()) return {{}, nullptr, {}, false, failure_};
  if (change == SceneFile::Change::kOverwritten) return {{}, nullptr, {}, false, notice_of(change)};
  if (needs_copy_) return {{}, nullptr, {}, true, {}};
  return {{}, file_->bytes(), tag(), false, {}};
}

}  // namespace palpate
