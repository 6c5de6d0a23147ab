/// \file
/// The scenes that a node may be told to feel.
#pragma once

#include <string>
#include <vector>

#include <palpate/live/live_hands.h>
#include <palpate/live/scene_library.h>

namespace palpate::node {

/// Those of its folders, the one it began with and the built-in one, and any other file by its path. Any
/// thread.
class NodeScenes {
 public:
  /// \param hands must outlive it \param folders of a SceneLibrary \throws Error for a folder that is none.
  NodeScenes(LiveHands& hands, const std::vector<std::string>& folders);

  /// JSON of scenes_json(). Looks at the disk.
  std::string list() const;
  /// Has another scene be read, and felt once it is there. Reads the beginning of its file. \param which an
  /// id of list(), or a path from the root on \throws Error for one that there is not, or cannot be felt.
  void open(const std::string& which);

 private:
  LiveHands& hands_;
  SceneLibrary library_;
};

/// Of what is felt, for people.
std::string felt_name(const LiveSystem& system);

}  // namespace palpate::node
