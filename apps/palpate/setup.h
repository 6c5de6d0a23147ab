/// \file
/// What `info` and `setup` say of a SceneSetup.
#pragma once

#include <palpate/live/live_config.h>
#include <palpate/scene/scene_setup.h>

#include "output.h"

namespace palpate::cli {

/// Of the tool of a configuration, whose shortest semi-axis counts. \throws Error.
SceneSetup propose_setup(const GaussianScene& scene, const Tool& tool);

/// On stdout: the proposals as options to paste, then each with its reason.
void print_setup(const SceneSetup& setup);

}  // namespace palpate::cli
