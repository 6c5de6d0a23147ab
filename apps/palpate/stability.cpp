// palpate stability: contact stability of a scene with several devices and hands, in virtual time.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/haptics/material_file.h>
#include <palpate/live/factories.h>
#include <palpate/live/live_scene.h>
#include <palpate/report/result_files.h>
#include <palpate/report/stability_page.h>
#include <palpate/report/stability_table.h>
#include <palpate/study/procedural.h>
#include <palpate/study/stability_study.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct StabilityOptions {
  CommonOptions common;
  LiveConfig live;
  std::vector<std::string> profiles;
  std::vector<std::string> models{kForceModelNames.begin(), kForceModelNames.end()};
  std::vector<HandProperties> hands;
  int places = 3;
  std::uint64_t seed = 1;
  double delay = 0.05;
  ResultNames results;
};

/// A scene and the places to press.
struct TrialGround {
  std::string name;
  std::unique_ptr<SceneIndex> index;
  Materials materials;
  std::vector<PressPlace> places;
};

/// Loads the scene file, or generates the table of make-scene with one material: simple shapes, so that
/// results remain comparable.
LoadedScene read_ground(const LiveConfig& live, TrialGround& ground, const Progress& progress) {
  const SceneConfig& scene = live.scene;
  if (!scene.path.empty()) {
    ground.name = std::filesystem::path(scene.path).filename().string();
    ground.materials = load_materials(live.force, scene.path, progress);
    return load(scene, progress);
  }
  constexpr const char* kTable = "table";
  ground.name = fmt::format("the built-in {}", kTable);
  if (!live.force.materials.empty())
    ground.materials = std::make_shared<MaterialMap>(read_materials(live.force.materials));
  return filter_made_scene(make_scene(*make_surface(kTable), {}), scene, notify, progress);
}

TrialGround ground_of(const StabilityOptions& options, const Progress& progress) {
  TrialGround ground;
  const LoadedScene loaded = read_ground(options.live, ground, progress);
  ground.index = std::make_unique<SceneIndex>(loaded.scene, options.live.scene.filter,
                                              options.live.scene.world_from_scene(), progress);
  try {
    ground.places = press_places(*ground.index, loaded.kept, options.live.tool, options.places, options.seed);
  } catch (const Error& error) {
    throw Error("{}: {}", ground.name, error.what());
  }
  return ground;
}

StabilityStudy study_of(const StabilityOptions& options, const TrialGround& ground) {
  StabilityStudy study;
  study.index = ground.index.get();
  study.tool = options.live.tool;
  study.places = ground.places;
  study.profiles = options.profiles;
  study.models = options.models;
  study.hands = options.hands;
  study.delay = options.delay;
  study.stiffness = options.live.force.proxy.stiffness;
  study.model = [&options, &ground](const std::string& name, Lookahead* ahead) {
    return make_force_model(force_model_kind(name), options.live.force, *ground.index, options.live.tool,
                            ground.materials, ahead);
  };
  return study;
}

std::string setup_text(const StabilityOptions& options, const TrialGround& ground) {
  return fmt::format(
      "A simulated hand approaches {} at {} place{}, presses {:g} mm beyond first contact (or with half of "
      "the device's maximum force), rests for {:g} s, slides for {:g} s at {:g} m/s, and lifts off; 1 kHz in "
      "virtual time; tool {}; stiffness {:g} N/m, friction {:g}. Delay of worker and hold: {:g} ms.",
      ground.name, ground.places.size(), ground.places.size() == 1 ? "" : "s", 1e3 * StabilityTrial::kPress,
      StabilityTrial::kRest, StabilityTrial::kSlide, StabilityTrial::kSlideSpeed,
      tool_in_words(options.live.tool), options.live.force.proxy.stiffness, options.live.force.proxy.friction,
      1e3 * options.delay);
}

Provenance provenance_of(const StabilityOptions& options, const TrialGround& ground) {
  using enum ConfigGroup;
  SceneOrigin scene{ground.name, {}};
  if (!options.live.scene.path.empty()) scene = scene_origin(options.live.scene);
  return made_by(options.common, scene, options.live, {kScene, kTool, kForce});
}

void run(const StabilityOptions& options) {
  check_results(options.results, {options.common.config, options.live.scene.path});
  ResultFiles files(options.results);
  const Progress progress = terminal_progress(options.common.quiet);
  const TrialGround ground = ground_of(options, progress);
  const StabilityStudy study = study_of(options, ground);
  const StabilityTables tables = measure_stability(study, progress);
  std::string subtitle;
  const std::vector<StabilityTrace> traces = stability_traces(study, tables, subtitle);
  const std::vector<Plot> figures = stability_figures(tables, traces, subtitle);
  const Provenance made = provenance_of(options, ground);
  files.write_csv(head_of(made) + stability_csv(tables));
  files.write_html(stability_page(tables, figures, setup_text(options, ground), to_toml(made)));
  files.write_figures(figures, "stability");
  if (options.common.json) {
    print_json(with_made(made, stability_json(tables)));
    return;
  }
  fmt::print("{}\n\n{}", setup_text(options, ground), stability_text(tables));
  print_written(files.written);
}

}  // namespace

Command declare_stability(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "stability",
                  "Contact stability of a scene across devices, hands and force models, in virtual time");
  auto options = std::make_shared<StabilityOptions>();
  options->profiles = profile_names();
  options->hands = usual_hands();
  declare_common(app, options->common, "print the tables as JSON");
  declare_scene(app, options->live, SceneArgument::kOptionalPositional);
  add_choices(app, "--profiles", options->profiles, profile_names(), "device profiles to compare");
  add_choices(app, "--models", options->models, {kForceModelNames.begin(), kForceModelNames.end()},
              "force models to compare");
  add_parsed(app, "--hands", "m,b,k,...",
             "hands: mass, damping and stiffness of each, in kg, N s/m and N/m (default: nine hands)",
             [options](const std::string& text) {
               const auto v = parse_numbers(text, 3, 300);
               if (v.size() % 3 != 0) throw BadValue("a hand is three numbers: m,b,k");
               options->hands.clear();
               for (std::size_t i = 0; i < v.size(); i += 3) options->hands.push_back(parse_hand(&v[i]));
             });
  add_count(app, "--places", options->places, 1, 100, "number of places to press");
  add_seed(app, options->seed, "random seed of the choice of places");
  add_number(app, "--delay", options->delay, 0.0, 0.09, "s",
             "delay of the worker and of the held force; 0 = try neither");
  declare_results(app, options->results, "all figures as CSV, one line per row");
  declare_field(app, options->live, "tool");
  declare_force_parameters(app, options->live);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
