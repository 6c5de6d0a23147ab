// palpate stability: what devices and hands make of a scene, in virtual time.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/haptics/material_file.h>
#include <palpate/live/factories.h>
#include <palpate/live/live_scene.h>
#include <palpate/report/result_files.h>
#include <palpate/report/stability_page.h>
#include <palpate/report/stability_table.h>
#include <palpate/study/procedural.h>
#include <palpate/study/stability.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct Options {
  CommonOptions common;
  LiveConfig live;
  std::vector<std::string> profiles;
  std::vector<std::string> models{kForceModelNames.begin(), kForceModelNames.end()};
  std::vector<HandProperties> hands;
  int places = 3;
  std::uint64_t seed = 1;
  double delay = 0.05;
  std::string csv, html, svg;
};

/// Light, usual and heavy, each held loosely, as usual, and firmly: the range of human hands.
std::vector<HandProperties> usual_hands() {
  std::vector<HandProperties> hands;
  for (const double mass : {0.05, 0.15, 0.3}) {
    for (const auto& [damping, stiffness] :
         {std::pair(1.0, 100.0), std::pair(3.0, 400.0), std::pair(10.0, 1000.0)})
      hands.push_back({mass, damping, stiffness});
  }
  return hands;
}

/// A scene and where it is pressed.
struct Ground {
  std::string name;
  std::unique_ptr<SceneIndex> index;
  Materials materials;
  std::vector<PressPlace> places;
};

/// Without a file the table of make-scene, of one stuff all over: plain shapes, whose figures stay
/// comparable.
LoadedScene read_ground(const LiveConfig& live, Ground& ground, const Progress& progress) {
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

Ground ground_of(const Options& options, const Progress& progress) {
  Ground ground;
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

StabilityTrial trial_of(const Options& options, const Ground& ground, const StabilityRow& row) {
  StabilityTrial trial;
  trial.index = ground.index.get();
  trial.tool = options.live.tool;
  trial.profile = device_profile(row.profile);
  trial.hand = row.hand;
  trial.model = [&options, &ground, name = row.model](Lookahead* ahead) {
    return make_force_model(force_model_kind(name), options.live.force, *ground.index, options.live.tool,
                            ground.materials, ahead);
  };
  if (row.source == ContactSource::kWorker) trial.worker_delay = row.delay;
  if (row.source == ContactSource::kHold) trial.hold = row.delay;
  // What has no potential, or is late, is not passive: it is shown as it is.
  trial.governed = row.source != ContactSource::kHold && row.model != "density";
  return trial;
}

/// Of the forces while sliding, as StabilityRow::force_off.
double force_off(const StabilityOutcome& outcome, const StabilityOutcome& reference) {
  constexpr double kShare = 0.95;
  const auto ticks = [](double seconds) { return static_cast<std::size_t>(seconds / StabilityTrial::kTick); };
  const std::size_t end = reference.ticks.size() - ticks(StabilityTrial::kLift);
  const std::size_t begin = end - ticks(StabilityTrial::kSlide);
  std::vector<double> off;
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    off.push_back(std::abs(outcome.ticks[i].force - reference.ticks[i].force));
    sum += reference.ticks[i].force;
  }
  const double mean = sum / static_cast<double>(off.size());
  return mean > 0.0 ? quantile(off, kShare) / mean : 0.0;
}

void measure(StabilityRow& row, const Options& options, const Ground& ground) {
  const StabilityTrial trial = trial_of(options, ground, row);
  StabilityTrial in_loop = trial;
  in_loop.worker_delay = in_loop.hold = 0.0;
  bool first = true;
  for (const PressPlace& place : ground.places) {
    const StabilityOutcome outcome = hold_on(trial, place, true);
    row.limit_cycle = std::max(row.limit_cycle, outcome.limit_cycle);
    row.port_energy = std::max(row.port_energy, outcome.port_energy);
    row.contact_changes = std::max(row.contact_changes, outcome.contact_changes);
    row.rest_force = first ? outcome.rest_force : std::min(row.rest_force, outcome.rest_force);
    if (row.fault == Fault::kNone) row.fault = outcome.fault;
    if (row.source != ContactSource::kLoop)
      row.force_off = std::max(row.force_off, force_off(outcome, hold_on(in_loop, place, true)));
    first = false;
  }
  if (row.model != "density")
    row.z_width = z_width(trial, ground.places.front(), options.live.force.proxy.stiffness);
}

std::vector<StabilityRow> rows_of(const Options& options) {
  std::vector<StabilityRow> rows;
  for (const std::string& profile : options.profiles) {
    for (const std::string& model : options.models) {
      for (const auto source : {ContactSource::kLoop, ContactSource::kWorker, ContactSource::kHold}) {
        if (source != ContactSource::kLoop && options.delay == 0.0) continue;
        for (const HandProperties& hand : options.hands) {
          StabilityRow row;
          row.profile = profile;
          row.model = model;
          row.hand = hand;
          row.source = source;
          row.delay = source == ContactSource::kLoop ? 0.0 : options.delay;
          rows.push_back(row);
        }
      }
    }
  }
  return rows;
}

StabilityTables measure_all(const Options& options, const Ground& ground, const Progress& progress) {
  StabilityTables tables{rows_of(options), {}};
  std::mutex watched;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, tables.rows.size(), [&](std::size_t i) {
    measure(tables.rows[i], options, ground);
    const std::scoped_lock lock(watched);
    report(progress, "holding", static_cast<double>(++done) / static_cast<double>(tables.rows.size() + 1));
  });
  for (const std::string& name : options.profiles) {
    const DeviceProfile& profile = device_profile(name);
    const double period = 1.0 / profile.capabilities.rate;
    for (const bool passivity : {false, true}) {
      tables.walls.push_back(
          {name, passivity, wall_z_width(profile, period, passivity),
           wall_bound(profile, period, passivity ? profile.capabilities.damping_max : 0.0)});
    }
  }
  report(progress, "holding", 1.0);
  return tables;
}

/// The first profile and model, in the hand that is in the middle, with every source.
std::vector<StabilityTrace> traces_of(const Options& options, const Ground& ground,
                                      const StabilityTables& tables, std::string& subtitle) {
  std::vector<StabilityTrace> traces;
  const HandProperties& hand = options.hands[options.hands.size() / 2];
  for (const StabilityRow& row : tables.rows) {
    if (row.profile != options.profiles.front() || row.model != options.models.front()) continue;
    if (hand_text(row.hand) != hand_text(hand)) continue;
    const std::string name = row.source == ContactSource::kLoop
                                 ? "contacts looked for in the loop"
                                 : fmt::format("{}, {:g} ms", to_string(row.source), 1e3 * row.delay);
    traces.push_back({name, hold_on(trial_of(options, ground, row), ground.places.front(), true).ticks});
  }
  subtitle =
      fmt::format("{}, {}, a hand of {}", options.profiles.front(), options.models.front(), hand_text(hand));
  return traces;
}

std::string setup_text(const Options& options, const Ground& ground) {
  return fmt::format(
      "A simulated hand comes in to {} at {} place{}, presses {:g} mm beyond first contact (or with half of "
      "what the device can), rests for {:g} s, slides for {:g} s at {:g} m/s, and lifts off; 1 kHz in "
      "virtual time; tool {}; stiffness {:g} N/m, friction {:g}. Worker and "
      "hold are {:g} ms "
      "late.",
      ground.name, ground.places.size(), ground.places.size() == 1 ? "" : "s", 1e3 * StabilityTrial::kPress,
      StabilityTrial::kRest, StabilityTrial::kSlide, StabilityTrial::kSlideSpeed,
      tool_text(options.live.tool), options.live.force.proxy.stiffness, options.live.force.proxy.friction,
      1e3 * options.delay);
}

Provenance provenance_of(const Options& options, const Ground& ground) {
  using enum ConfigGroup;
  SceneOrigin scene{ground.name, {}};
  if (!options.live.scene.path.empty()) scene = scene_origin(options.live.scene);
  return made_by(options.common, scene, options.live, {kScene, kTool, kForce});
}

void run(const Options& options) {
  check_output(options.csv, {options.common.config, options.live.scene.path}, "--csv");
  check_output(options.html, {options.common.config, options.live.scene.path, options.csv}, "--html");
  check_figure_folder(options.svg);
  ResultFile csv(options.csv), html(options.html);
  const Progress progress = terminal_progress(options.common.quiet);
  const Ground ground = ground_of(options, progress);
  const StabilityTables tables = measure_all(options, ground, progress);
  std::string subtitle;
  const std::vector<StabilityTrace> traces = traces_of(options, ground, tables, subtitle);
  const std::vector<Plot> figures = stability_figures(tables, traces, subtitle);
  std::vector<std::string> written;
  const Provenance made = provenance_of(options, ground);
  csv.write(head_of(made) + stability_csv(tables), written);
  html.write(stability_page(tables, figures, setup_text(options, ground), to_toml(made)), written);
  write_figures(figures, options.svg, "stability", written);
  if (options.common.json) {
    print_json(with_made(made, stability_json(tables)));
    return;
  }
  fmt::print("{}\n\n{}", setup_text(options, ground), stability_text(tables));
  for (const std::string& path : written) fmt::print("wrote {}\n", printable(path));
}

}  // namespace

Command declare_stability(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "stability",
                  "How firmly a scene can be held on to: devices, hands and models, in virtual time");
  auto options = std::make_shared<Options>();
  options->profiles = profile_names();
  options->hands = usual_hands();
  declare_common(app, options->common, "print the tables as JSON");
  declare_scene(app, options->live, SceneArgument::kOptionalPositional);
  add_choices(app, "--profiles", options->profiles, profile_names(), "devices to hold");
  add_choices(app, "--models", options->models, {kForceModelNames.begin(), kForceModelNames.end()},
              "force models to compare");
  add_parsed(app, "--hands", "m,b,k,...", "hands, three numbers each: kg, N s/m and N/m (default: nine)",
             [options](const std::string& text) {
               const auto v = parse_numbers(text, 3, 300);
               if (v.size() % 3 != 0) throw BadValue("a hand is three numbers: m,b,k");
               options->hands.clear();
               for (std::size_t i = 0; i < v.size(); i += 3) options->hands.push_back(parse_hand(&v[i]));
             });
  add_count(app, "--places", options->places, 1, 100, "where the scene is pressed");
  add_seed(app, options->seed, "of the choice of places");
  add_number(app, "--delay", options->delay, 0.0, 0.09, "s",
             "of the worker, and of the force that is held; 0: neither");
  add_text(app, "--csv", options->csv, "T.csv", "all figures as CSV, a line a row");
  add_text(app, "--html", options->html, "P.html", "tables and figures as one self-contained page");
  add_text(app, "--svg", options->svg, "DIR", "a folder, for the figures of the page as files");
  declare_field(app, options->live, "tool");
  declare_force_parameters(app, options->live);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
