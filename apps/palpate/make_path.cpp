// palpate make-path: a path that touches a scene, for users without a recorded motion.
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/haptics/density_force.h>
#include <palpate/record/playback.h>
#include <palpate/study/touch_path.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct MakePathOptions {
  CommonOptions common;
  LiveConfig live;
  std::string out;
  TouchPathOptions path;
};

/// Generates the path; errors name the scene.
Trajectory make_path(const MakePathOptions& options, const SceneIndex& index, const EllipsoidScene& kept) {
  try {
    return touch_path(index, kept, options.live.tool, options.path);
  } catch (const Error& error) {
    throw Error("{}: {}", options.live.scene.path, error.what());
  }
}

Provenance provenance_of(const MakePathOptions& options) {
  using enum ConfigGroup;
  Provenance known = made_by(options.common, options.live, {kScene, kTool});
  set(known, "rate", fmt::format("{}", options.path.rate));  // of poses; a live loop has a field of that name
  return known;
}

void run(const MakePathOptions& options) {
  check_output(options.out, {options.live.scene.path, options.common.config});
  const Progress progress = terminal_progress(options.common.quiet);
  const LoadedScene loaded = load(options.live.scene, progress);
  const SceneIndex index(loaded.scene, options.live.scene.filter, options.live.scene.world_from_scene(),
                         progress);
  const Trajectory path = make_path(options, index, loaded.kept);
  write_trajectory(path, options.out, to_toml(provenance_of(options)));
  DensityForce model;
  const auto contacts = contact_episodes(play_back(index, options.live.tool, model, path)).size();
  if (contacts < static_cast<std::size_t>(options.path.touches)) {
    notify(fmt::format("note: {}: only {} of {} places found that the tool can touch",
                       options.live.scene.path, contacts, options.path.touches));
  }
  if (options.common.quiet) return;
  fmt::print("wrote {}: {} touches, {} poses, {:.1f} s\n", printable(options.out), contacts, path.size(),
             path.back().t);
}

}  // namespace

Command declare_make_path(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "make-path", "Trajectory file of a path that touches a scene at several places");
  auto options = std::make_shared<MakePathOptions>();
  declare_common(app, options->common);
  add_text(app, "--out", options->out, "T.csv", "output file of the trajectory").required();
  add_count(app, "--touches", options->path.touches, 1, 1000, "number of places to touch");
  add_seed(app, options->path.seed, "random seed of the choice of places");
  constexpr double kMost = 1e3;
  add_number(app, "--press", options->path.press, 0.0, kMost, "m", "depth of the press beyond first contact");
  add_number(app, "--slide", options->path.slide, 0.0, kMost, "m", "length of the slide along the surface");
  add_number(app, "--rate", options->path.rate, 1.0, 1e5, "Hz", "rate of the poses");
  declare_scene(app, options->live, SceneArgument::kPositional);
  declare_field(app, options->live, "tool");
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
