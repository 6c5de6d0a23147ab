/// \file
/// Scenes that a node can open.
#pragma once

#include <string>
#include <vector>

#include <palpate/live/live_hands.h>
#include <palpate/live/scene_library.h>

namespace palpate::node {

/// The scenes of the node's folders, the initial scene, the built-in scene, and any other file by its path.
/// Any thread.
class NodeScenes {
 public:
  /// \param hands must outlive this \param folders of a SceneLibrary \throws Error if one is not a folder.
  NodeScenes(LiveHands& hands, const std::vector<std::string>& folders);

  /// JSON of scenes_json(). Reads the folders.
  std::string list() const;
  /// Starts loading another scene, which is felt once it is loaded. Reads the beginning of its file.
  /// \param which id from list(), or an absolute path \throws Error if it does not exist or cannot be felt.
  void open(const std::string& which);

 private:
  LiveHands& hands_;
  SceneLibrary library_;
};

/// Display name of the current scene.
std::string felt_name(const LiveSystem& system);

}  // namespace palpate::node
