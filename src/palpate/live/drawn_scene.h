/// \file
/// The scene as the gateway serves it for drawing. Internal to live/.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include <palpate/base/file.h>
#include <palpate/live/live_config.h>
#include <palpate/live/scene_file.h>

namespace palpate {

/// A scene's file, or, if the viewer cannot draw that, a copy in the temporary folder that it can; or the
/// bytes of the built-in scene. The copy is made when it is first asked for. Any thread.
class DrawnScene {
 public:
  /// \throws Error if the file cannot be read.
  explicit DrawnScene(const SceneConfig& scene);

  /// Returns SceneConfig::path.
  const std::string& path() const { return path_; }
  /// Returns the scene's file; null: the built-in scene.
  const SceneFile* file() const { return file_.get(); }
  /// Returns the size of the scene's file or of the built-in scene. Unit: [bytes].
  std::uint64_t size() const { return file_ ? file_->bytes()->size() : bytes_.size(); }
  /// Returns the entity tag of the scene.
  std::string tag() const { return file_ ? file_->tag() : "built-in"; }

  /// Returns whether make_copy() has to be called; true once.
  bool wants_copy() { return needs_copy_ && !asked_.exchange(true); }
  /// Makes the copy, which takes as long as reading the scene.
  void make_copy();

  /// What can be served now.
  struct Served {
    std::string_view bytes;                 ///< of the built-in scene
    std::shared_ptr<const InputFile> file;  ///< null: `bytes`, or nothing
    std::string tag;                        ///< entity tag
    bool is_coming = false;                 ///< the copy is being made
    std::string failure;                    ///< why there is nothing; empty: there is something, or will be
  };
  Served served() const;

  static constexpr std::uint64_t kRoom = std::uint64_t{256} << 20;  ///< bytes that must stay free on the disk

 private:
  std::shared_ptr<const InputFile> copied() const;

  std::string path_;
  std::unique_ptr<const SceneFile> file_;
  std::string bytes_;
  bool needs_copy_ = false;
  std::atomic<bool> asked_ = false;
  mutable std::mutex mutex_;  ///< guards the members below
  std::shared_ptr<const InputFile> copy_;
  std::string failure_;
};

}  // namespace palpate
