#include <palpate/live/live_config.h>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/live/live_scene.h>

namespace palpate {
ForceModelKind force_model_kind(std::string_view name) {
  const auto at = std::find(kForceModelNames.begin(), kForceModelNames.end(), name);
  if (at == kForceModelNames.end())
    throw Error("'{}' is not a force model; use one of {}", name, fmt::join(kForceModelNames, ", "));
  return static_cast<ForceModelKind>(at - kForceModelNames.begin());
}

Similarity SceneConfig::world_from_scene() const { return upright(frame, registration); }

std::string SceneConfig::name() const {
  return path.empty() ? fmt::format("the built-in {}", kStillLife) : path;
}

std::string SceneConfig::frame_note() const {
  const char* mirror = registration.mirrored ? ", its x axis reversed" : "";
  if (frame != UpAxis::kAsIs)
    return fmt::format("captured frame taken as {}{}, turned to world z up", to_string(frame), mirror);
  return fmt::format(
      "no frame is declared in the file: captured axes are taken as world axes{}, z up (see --frame)",
      mirror);
}

}  // namespace palpate
