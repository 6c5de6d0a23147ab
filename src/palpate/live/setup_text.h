/// \file
/// Text form of a SceneSetup.
#pragma once

#include <string>

#include <palpate/scene/scene_setup.h>

namespace palpate {

/// Returns the command-line options to paste, and one line with the reason for each.
std::string setup_text(const SceneSetup& setup);

}  // namespace palpate
