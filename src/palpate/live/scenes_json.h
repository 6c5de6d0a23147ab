/// \file
/// JSON list of the scenes of a SceneLibrary, for clients of the gateway and of the ROS nodes.
#pragma once

#include <vector>

#include <palpate/live/scene_library.h>
#include <palpate/rosbridge/message.h>

namespace palpate {

/// Returns an array of {id, name, bytes, refusal}.
inline Json scenes_json(const std::vector<SceneLibrary::Entry>& entries) {
  Json list = Json::array();
  for (const SceneLibrary::Entry& entry : entries)
    list.push_back(
        {{"id", entry.id}, {"name", entry.name}, {"bytes", entry.bytes}, {"refusal", entry.refusal}});
  return list;
}

}  // namespace palpate
