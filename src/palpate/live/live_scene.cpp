#include <palpate/live/live_scene.h>

#include <utility>

#include <fmt/format.h>

#include <palpate/scene/load_scene.h>

namespace palpate {
namespace {

void say(const Notify& notify, const std::string& line) {
  if (notify) notify(line);
}

/// Reports what the filter dropped, if the user should know.
void tell(const FilterReport& f, const std::string& path, const Notify& notify) {
  if (f.kept == 0) {
    say(notify,
        fmt::format("warning: {}: no Gaussian passes the filter: of {} Gaussians {} are defective, {} below "
                    "--opacity-min, {} below --iso, {} above --max-scale, {} outside the crop",
                    path, f.total, f.defective(), f.low_opacity, f.below_iso, f.over_max_scale,
                    f.outside_crop));
  } else if (f.defective() != 0) {
    say(notify, fmt::format("note: {}: {} of {} Gaussians cannot collide and are left out (see palpate info)",
                            path, f.defective(), f.total));
  }
}

}  // namespace

const StillLife& built_in_scene() {
  static const StillLife made = make_still_life();
  return made;
}

LoadedScene filter_made_scene(GaussianScene scene, const SceneConfig& config, const Notify& notify,
                              const Progress& progress) {
  LoadedScene result;
  result.scene = std::move(scene);
  result.kept =
      filter_scene(result.scene, config.filter, config.world_from_scene(), result.filtered, progress);
  tell(result.filtered, config.name(), notify);
  return result;
}

LoadedScene load_scene(const SceneConfig& config, const Notify& notify, const Progress& progress) {
  return filter_made_scene(load_scene(config.path, progress), config, notify, progress);
}

LoadedScene load_or_make_scene(const SceneConfig& config, const Notify& notify, const Progress& progress) {
  return config.path.empty() ? filter_made_scene(built_in_scene().scene, config, notify, progress)
                             : load_scene(config, notify, progress);
}

SceneIndex open_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                      const Progress& progress) {
  const OpenedIndex opened =
      open_index(config.path, config.filter, config.world_from_scene(), files, progress);
  if (opened.rejected) say(notify, fmt::format("note: {}; rebuilt", *opened.rejected));
  if (opened.not_written) {
    say(notify, fmt::format("warning: {}; the index is in memory, and rebuilt by every command",
                            *opened.not_written));
  }
  if (opened.origin == OpenedIndex::Origin::kNewFile && progress) {  // only if a user is watching
    say(notify,
        fmt::format("note: wrote {}, reused when this scene is opened again", index_path(config.path)));
  }
  tell(opened.report, config.path, notify);
  return opened.index;
}

SceneIndex open_or_make_index(const SceneConfig& config, IndexFiles files, const Notify& notify,
                              const Progress& progress) {
  if (!config.path.empty()) return open_index(config, files, notify, progress);
  return {load_or_make_scene(config, notify, progress).scene, config.filter, config.world_from_scene(),
          progress};
}

}  // namespace palpate
