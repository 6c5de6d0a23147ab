// palpate setup: proposed frame, scale, filter and crop of an unknown scene, as a configuration file.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/setup_json.h>
#include <palpate/live/setup_text.h>
#include <palpate/scene/load_scene.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

void apply(const SceneSetup& setup, SceneConfig& scene) {
  scene.frame = setup.frame.value;
  scene.registration.scale = setup.scale.value;
  scene.filter.opacity_min = setup.opacity_min.value;
  scene.filter.max_scale = setup.max_scale.value;
  scene.filter.crop_box = setup.crop_box.value;
}

struct SetupOptions {
  CommonOptions common;
  LiveConfig live;
  std::string out;
};

/// Provenance of the request; the proposals are not part of it.
Provenance provenance_of(const SetupOptions& options) {
  Provenance known = made_by(options.common, options.live, {ConfigGroup::kTool});
  set(known, "scene", toml_quoted(options.live.scene.path));
  return known;
}

void run(const SetupOptions& options) {
  if (!options.out.empty()) check_output(options.out, {options.live.scene.path, options.common.config});
  LiveConfig live = options.live;
  const GaussianScene scene = load_scene(live.scene.path, terminal_progress(options.common.quiet));
  const SceneSetup setup = propose_setup(scene, live.tool.thinnest());
  apply(setup, live.scene);
  if (!options.out.empty()) {
    OutputFile file(options.out);
    file.write(head_of(provenance_of(options)) + '\n' + to_toml(live, TomlFields::kSaved));
    file.commit();
  }
  if (options.common.json) {
    Json json = setup_json<Json>(setup);
    json["made"] = made_json(provenance_of(options));
    print_json(json);
  } else if (!options.common.quiet) {
    fmt::print("{}", setup_text(setup));
    if (!options.out.empty())
      fmt::print("\nwrote {}; next: palpate run {} --config {}\n", printable(options.out),
                 printable(live.scene.path), printable(options.out));
  }
}

}  // namespace

Command declare_setup(CLI::App& parent) {
  CLI::App& app = add_command(
      parent, "setup", "Proposed frame, scale, filter and crop for an unknown scene, each with a reason");
  auto options = std::make_shared<SetupOptions>();
  declare_common(app, options->common, "print the proposals as JSON");
  add_text(app, "SCENE", options->live.scene.path, "", "3DGS scene, .ply or .splat").required();
  add_text(app, "--out", options->out, "FILE.toml", "write the proposals as a file for --config");
  declare_field(app, options->live, "tool");
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
