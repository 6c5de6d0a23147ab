/// \file
/// Confidence of contacts.
#pragma once

#include <vector>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Returns the confidence that a surface exists at each of `contacts`, those of `tool` at `pose`, in [0, 1];
/// see SurfacePatch. The scene is viewed at the detail that the proxy uses.
std::vector<double> confidence(const SceneIndex& index, const Tool& tool, const Pose& pose,
                               const ProxyParameters& parameters, const std::vector<Contact>& contacts);

}  // namespace palpate
