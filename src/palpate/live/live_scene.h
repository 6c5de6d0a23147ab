/// \file
/// Scenes and indices of a SceneConfig.
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

/// Told what a person should know, in one line: "note: ..." or "warning: ...". May be empty.
using Notify = std::function<void(const std::string& line)>;

/// The scene that there is without a file: made when it is first asked for, which takes a second, and kept.
/// Any thread.
const StillLife& built_in_scene();

/// What a scene and its configuration come to.
struct LoadedScene {
  GaussianScene scene;
  FilterReport filtered;
  EllipsoidScene kept;
};

/// Loads and filters the file. Tells where nothing is left to touch. \throws Error.
LoadedScene load_scene(const SceneConfig& config, const Notify& notify, const Progress& progress = {});
/// The same; without a path, of the built-in scene.
LoadedScene load_or_make_scene(const SceneConfig& config, const Notify& notify,
                               const Progress& progress = {});

/// Filters a scene that was made rather than loaded; `config` says how. Tells where nothing is left to touch.
LoadedScene filter_made_scene(GaussianScene scene, const SceneConfig& config, const Notify& notify,
                              const Progress& progress = {});

/// The index of the scene's file; tells what became of the index file beside it. \throws Error.
SceneIndex open_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                      const Progress& progress = {});
/// The same; without a path, of the built-in scene.
SceneIndex open_or_make_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                              const Progress& progress = {});

}  // namespace palpate
