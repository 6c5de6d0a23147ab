/// \file
/// A SceneSetup for a person.
#pragma once

#include <string>

#include <palpate/scene/scene_setup.h>

namespace palpate {

/// Options to paste, and a line for each with its reason.
std::string setup_text(const SceneSetup& setup);

}  // namespace palpate
