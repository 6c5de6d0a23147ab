// palpate reproduce: the paper's evaluation on a simulated room-scale device, in virtual time.
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/factories.h>
#include <palpate/report/reproduction_report.h>
#include <palpate/report/result_files.h>
#include <palpate/study/machine.h>
#include <palpate/study/room_placement.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct ReproduceOptions {
  CommonOptions common;
  LiveConfig live;
  std::string plant = "own";
  int touches = 7;
  double press = RoomPathOptions().press;
  std::uint64_t seed = 1;
  double stall = 0.05;      ///< stall of the forces, as in the paper. Unit: [s].
  bool registered = false;  ///< the user gave a registration
  ResultNames results;
};

/// A scene placed in the room, with its contact queries.
struct Ground {
  std::string name;
  std::unique_ptr<AnalyticSurface> surface;  ///< null for a scene file
  LoadedScene loaded;
  std::unique_ptr<SceneIndex> index;
  std::unique_ptr<PaperPipeline> paper;
};

Ground ground_of(ReproduceOptions& options, const Eigen::Vector3d& home, const Progress& progress) {
  Ground ground;
  SceneConfig& scene = options.live.scene;
  GaussianScene gaussians;
  if (scene.path.empty()) {
    ground.surface = make_surface("truck");
    report(progress, "generating the scene", 0.0);
    gaussians = procedural_truck(*ground.surface, options.seed);
    ground.name = "a procedural truck";
  } else {
    gaussians = load(scene, progress).scene;
    ground.name = std::filesystem::path(scene.name()).filename().string();
  }
  const double radius = options.live.tool.thinnest();
  if (!options.registered) {
    const RoomPlacement placed = place_in_room(gaussians, scene.filter, radius, home);
    scene.frame = placed.frame;
    scene.registration = placed.registration;
    scene.filter = placed.filter;
  }
  const Similarity registration = scene.world_from_scene();
  ground.loaded.scene = std::move(gaussians);
  ground.loaded.kept = filter_scene(ground.loaded.scene, scene.filter, registration, ground.loaded.filtered);
  ground.index = std::make_unique<SceneIndex>(ground.loaded.scene, scene.filter, registration, progress);
  const double reach = PaperPipeline::default_search_radius(ground.loaded.kept, options.live.tool.radius());
  ground.paper = std::make_unique<PaperPipeline>(ground.loaded.kept, reach);
  return ground;
}

std::string setup_text(const ReproduceOptions& options, const Ground& ground) {
  const Similarity& placed = options.live.scene.registration;
  return fmt::format(
      "{}, {} Gaussians, of which {} have an opacity above {:g}; registered into the room with scale {:.4g} "
      "and "
      "translation {:.3f}, {:.3f}, {:.3f} m. A simulated room-scale admittance device ({} mechanics), held "
      "by a hand of {:g} kg, {:g} N s/m and {:g} N/m; 1 kHz, virtual time; tool {}; {} places, seed {}. "
      "Left: the paper's pipeline with its force (density); right: this project's defaults. {}",
      ground.name, ground.loaded.filtered.total, ground.loaded.kept.size(),
      options.live.scene.filter.opacity_min, placed.scale, placed.translation.x(), placed.translation.y(),
      placed.translation.z(), options.plant, options.live.device.hand.mass, options.live.device.hand.damping,
      options.live.device.hand.stiffness, tool_in_words(options.live.tool), options.touches, options.seed,
      machine());
}

ReproductionModel model_of(const ReproduceOptions& options, const Ground& ground, ForceModelKind kind,
                           double stall) {
  ReproductionModel model;
  model.name = to_string(kind);
  model.force = make_force_model(kind, options.live.force, *ground.index, options.live.tool);
  model.contacts = kind == ForceModelKind::kDensity ? ground.paper.get() : nullptr;
  model.stall = stall;
  return model;
}

Provenance provenance_of(const ReproduceOptions& options, const Ground& ground) {
  using enum ConfigGroup;
  SceneOrigin scene{ground.name, {}};
  if (!options.live.scene.path.empty()) scene = scene_origin(options.live.scene);
  return made_by(options.common, scene, options.live, {kScene, kTool, kForce, kDevice, kLoop});
}

void run(ReproduceOptions options) {
  LiveConfig& live = options.live;
  check_results(options.results,
                {live.scene.path, live.device.chain, live.force.materials, options.common.config});
  ResultFiles files(options.results);
  const Progress progress = terminal_progress(options.common.quiet);
  live.device.kind = options.plant == "mujoco" ? DeviceKind::kGiantMujoco : DeviceKind::kGiant;
  const GiantSetup setup = giant_setup(live.device, live.loop.rate, live.force.proxy.stiffness);
  const Pose home = rest_of_handle(setup.chain);
  const Ground ground = ground_of(options, home.position, progress);

  RoomPathOptions way;
  way.touches = static_cast<std::size_t>(options.touches);
  way.seed = options.seed;
  way.press = options.press;
  way.home = home;
  way.reach = giant_reach();
  ReproductionResult result;
  report(progress, "planning the path", 0.0);
  result.path = room_path(*ground.index, ground.loaded.kept, live.tool, way);

  const ReproductionScene scene{ground.index.get(), &ground.loaded.kept, ground.paper.get(),
                                ground.surface.get(), live.scene.world_from_scene()};
  const auto plant = [kind = live.device.kind](const GiantSetup& made, HandPath hand) {
    return make_giant_plant(kind, made, std::move(hand));
  };
  const std::vector<double> stalls = options.stall > 0.0 ? std::vector{0.0, options.stall} : std::vector{0.0};
  for (const double stall : stalls) {
    for (const auto device : {ReproductionDevice::kAdmittance, ReproductionDevice::kImpedance}) {
      for (const auto kind : {ForceModelKind::kDensity, live.force.model}) {
        result.runs.push_back(reproduce(scene, live.tool, result.path, model_of(options, ground, kind, stall),
                                        device, setup, plant, progress));
      }
    }
  }
  report(progress, "simulating", 1.0);
  result.claims = claims(ground.loaded.filtered.total, ground.loaded.kept.size(), result.path, result.runs[0],
                         result.runs[1]);
  result.setup = setup_text(options, ground);

  const std::vector<Plot> figures = reproduction_figures(result, ground.loaded.kept);
  const Provenance made = provenance_of(options, ground);
  if (files.has_csv()) files.write_csv(head_of(made) + reproduction_csv(result));
  if (files.has_html()) files.write_html(reproduction_page(result, figures, to_toml(made)));
  files.write_figures(figures, "reproduce");
  if (options.common.json) {
    Json json = reproduction_json(result);
    json["made"] = made_json(made);
    print_json(json);
  } else if (!options.common.quiet) {
    fmt::print("{}", reproduction_text(result));
    print_written(files.written);
  }
}

}  // namespace

Command declare_reproduce(CLI::App& parent) {
  CLI::App& app = add_command(parent, "reproduce",
                              "Reproduction of the paper's evaluation on a simulated room-scale device");
  auto options = std::make_shared<ReproduceOptions>();
  declare_common(app, options->common, "print all figures as JSON");
  LiveConfig& live = options->live;
  live.tool = Tool(Eigen::Vector3d::Constant(0.03));
  live.device.hand = {0.15, 4.0, 400.0};
  declare_scene(app, live, SceneArgument::kOptionalPositional);
  add_choice(app, "--plant", options->plant, {"own", "mujoco"},
             "mechanics of the device: the project's own or MuJoCo");
  add_count(app, "--touches", options->touches, 2, 26, "number of places to touch; 7 in the paper");
  add_number(app, "--press", options->press, 0.001, 0.2, "m",
             "commanded depth of the hand beyond first contact");
  add_number(app, "--stall", options->stall, 0.0, 1.0, "s",
             "computation and hold time of the forces in additional runs; 0 = no additional runs");
  add_seed(app, options->seed, "random seed of the scene and of the choice of places");
  for (const char* name : {"tool", "hand", "chain", "virtual-mass", "virtual-damping"})
    declare_field(app, live, name);
  declare_results(app, options->results, "every tick of the first two runs, as CSV");
  declare_field(app, live, "model");
  declare_force_parameters(app, live);
  return {&app, [=, &app] {
            options->registered = false;
            for (const char* name : {"--scale", "--frame", "--rotate", "--translate", "--mirror"})
              options->registered = options->registered || is_given(app, name);
            run(*options);
          }};
}

}  // namespace palpate::cli
