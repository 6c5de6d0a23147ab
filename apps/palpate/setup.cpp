// palpate setup: how an unknown scene might be felt, as a configuration file.
#include "setup.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/setup_json.h>
#include <palpate/scene/load_scene.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

/// An option to paste, empty if nothing needs to be set, and why.
struct Line {
  std::string option, reason;
};

std::vector<Line> lines_of(const SceneSetup& setup) {
  const bool turned = setup.frame.value != UpAxis::kAsIs;
  const auto& longest = setup.max_scale.value;
  const auto& crop = setup.crop_box.value;
  return {
      {turned ? fmt::format("--frame {}", to_string(setup.frame.value)) : "", setup.frame.reason},
      {fmt::format("--scale {}", setup.scale.value), setup.scale.reason},
      {fmt::format("--opacity-min {}", setup.opacity_min.value), setup.opacity_min.reason},
      {longest ? fmt::format("--max-scale {:.3g}", *longest) : "", setup.max_scale.reason},
      {crop ? fmt::format("--crop-box {:.3g}", fmt::join(corners(*crop), ",")) : "", setup.crop_box.reason}};
}

void apply(const SceneSetup& setup, SceneConfig& scene) {
  scene.frame = setup.frame.value;
  scene.registration.scale = setup.scale.value;
  scene.filter.opacity_min = setup.opacity_min.value;
  scene.filter.max_scale = setup.max_scale.value;
  scene.filter.crop_box = setup.crop_box.value;
}

struct Options {
  CommonOptions common;
  LiveConfig live;
  std::string out;
};

/// What was asked, not what is proposed.
Provenance provenance_of(const Options& options) {
  Provenance known = made_by(options.common, options.live, {ConfigGroup::kTool});
  set(known, "scene", toml_quoted(options.live.scene.path));
  return known;
}

void run(const Options& options) {
  if (!options.out.empty()) check_output(options.out, {options.live.scene.path, options.common.config});
  LiveConfig live = options.live;
  const GaussianScene scene = load_scene(live.scene.path, terminal_progress(options.common.quiet));
  const SceneSetup setup = propose_setup(scene, live.tool);
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
    print_setup(setup);
    if (!options.out.empty())
      fmt::print("\nwrote {}; next: palpate run {} --config {}\n", printable(options.out),
                 printable(live.scene.path), printable(options.out));
  }
}

}  // namespace

SceneSetup propose_setup(const GaussianScene& scene, const Tool& tool) {
  return palpate::propose_setup(scene, tool.thinnest());
}

void print_setup(const SceneSetup& setup) {
  std::vector<std::string> options;
  for (const Line& line : lines_of(setup))
    if (!line.option.empty()) options.push_back(line.option);
  fmt::print("proposed          {}\n", fmt::join(options, " "));
  for (const auto& [option, reason] : lines_of(setup)) {
    const std::string name = option.substr(0, option.find(' '));
    fmt::print("  {:<15} {}\n", name.empty() ? "-" : name, reason);
  }
}

Command declare_setup(CLI::App& parent) {
  CLI::App& app = add_command(parent, "setup",
                              "Frame, scale, filter and crop for an unknown scene, each with its reason");
  auto options = std::make_shared<Options>();
  declare_common(app, options->common, "print the proposals as JSON");
  add_text(app, "SCENE", options->live.scene.path, "", "3DGS scene, .ply or .splat").required();
  add_text(app, "--out", options->out, "FILE.toml", "write them as a file for --config");
  declare_field(app, options->live, "tool");
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
