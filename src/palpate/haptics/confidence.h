/// \file
/// How well supported contacts are.
#pragma once

#include <vector>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// How far there is a surface at each of `contacts`, those of `tool` at `pose`, in [0, 1]; see SurfacePatch.
/// What is there is seen at the detail that the proxy sees.
std::vector<double> confidence(const SceneIndex& index, const Tool& tool, const Pose& pose,
                               const ProxyParameters& parameters, const std::vector<Contact>& contacts);

}  // namespace palpate
