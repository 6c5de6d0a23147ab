/// \file
/// Loading of the scene and the index of a SceneConfig.
#pragma once

#include <functional>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/open_index.h>
#include <palpate/collision/scene_index.h>
#include <palpate/live/live_config.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>
#include <palpate/study/still_life.h>

namespace palpate {

/// Receives notices for the user, one line each: "note: ..." or "warning: ...". May be empty.
using Notify = std::function<void(const std::string& line)>;

/// Returns the built-in scene, used without a file. Generated on the first call, which takes a second, and
/// kept. Any thread.
const StillLife& built_in_scene();

/// A loaded scene before and after filtering.
struct LoadedScene {
  GaussianScene scene;
  FilterReport filtered;
  EllipsoidScene kept;
};

/// Loads and filters the scene's file. Notifies if nothing is left to touch. \throws Error.
LoadedScene load_scene(const SceneConfig& config, const Notify& notify, const Progress& progress = {});
/// The same; uses the built-in scene if the path is empty.
LoadedScene load_or_make_scene(const SceneConfig& config, const Notify& notify,
                               const Progress& progress = {});

/// Filters a generated scene according to `config`. Notifies if nothing is left to touch.
LoadedScene filter_made_scene(GaussianScene scene, const SceneConfig& config, const Notify& notify,
                              const Progress& progress = {});

/// Opens or builds the index of the scene's file; notifies about the use of the index file beside it. \throws
/// Error.
SceneIndex open_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                      const Progress& progress = {});
/// The same; uses the built-in scene if the path is empty.
SceneIndex open_or_make_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                              const Progress& progress = {});

}  // namespace palpate
