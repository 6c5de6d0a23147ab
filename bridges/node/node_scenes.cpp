#include "node_scenes.h"

#include <palpate/base/error.h>
#include <palpate/live/scenes_json.h>

namespace palpate::node {

NodeScenes::NodeScenes(LiveHands& hands, const std::vector<std::string>& folders)
    : hands_(hands), library_(folders, hands.first().settings().scene.path, "parameter 'scenes':") {}

std::string NodeScenes::list() const { return encode_json(scenes_json(library_.list())); }

void NodeScenes::open(const std::string& which) {
  hands_.open_scene(which.starts_with('/') ? which : library_.path_of(which));
}

std::string felt_name(const LiveSystem& system) {
  SceneConfig scene;
  scene.path = system.felt()->path();
  return scene.name();
}

}  // namespace palpate::node
