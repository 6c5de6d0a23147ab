// palpate reproduce: the paper's evaluation on a simulated room-scale device, in virtual time.
#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/factories.h>
#include <palpate/report/reproduction_report.h>
#include <palpate/report/result_files.h>
#include <palpate/scene/scene_setup.h>
#include <palpate/study/capture_defects.h>
#include <palpate/study/machine.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

/// Beside where the handle rests, a scene may be so large, so far in y from there, and its top so far below
/// what the handle reaches: with room to walk around, and to pass above. Unit: [m].
const Eigen::Vector3d kFits(3.5, 1.9, 1.3);
constexpr double kAside = 0.35, kBelow = 0.18;
/// A larger one lies below where the handle rests, and this many of its Gaussians fill this much of the room:
/// the paper's million, and a share that was chosen by trial on one captured city, where contacts then have
/// about as many Gaussians as the paper's. Unit: [m], [m], 1.
const Eigen::Array2d kRoom(4.2, 5.0);
constexpr double kUnderHandle = 0.1;
constexpr std::size_t kFilling = 1'150'000;

struct Options {
  CommonOptions common;
  LiveConfig live;
  std::string plant = "own";
  int touches = 7;
  double press = RoomPathOptions().press;
  std::uint64_t seed = 1;
  double stall = 0.05;      ///< the paper's. Unit: [s].
  bool registered = false;  ///< by the user
  std::string csv, html, svg;
};

/// A scene in the room.
struct Ground {
  std::string name;
  std::unique_ptr<AnalyticSurface> surface;  ///< null for a file
  LoadedScene loaded;
  std::unique_ptr<SceneIndex> index;
  std::unique_ptr<PaperPipeline> paper;
};

GaussianScene truck(const AnalyticSurface& surface, std::uint64_t seed) {
  ProceduralOptions made;
  made.seed = seed;
  made.spacing = 0.0068;  // a million on its surface
  made.noise = 0.001;
  CaptureDefects defects;
  defects.floaters = defects.faint = true;
  return make_capture(surface, made, defects);
}

EllipsoidScene kept_of(const GaussianScene& scene, const SceneConfig& config) {
  FilterReport report;
  EllipsoidScene kept = filter_scene(scene, config.filter, config.world_from_scene(), report);
  if (kept.size() == 0) throw Error("{}: nothing is left to touch; lower --opacity-min", config.name());
  return kept;
}

/// How much larger `kept` may be for kFilling of it to be left in kRoom about `middle`; at least 1.
double enlarged_to_fill(const EllipsoidScene& kept, const Eigen::Vector3d& middle) {
  if (kept.size() <= kFilling) return 1.0;
  std::vector<double> share;  // of the room, in which a centre is
  for (const Ellipsoid& e : kept.ellipsoids)
    share.push_back(((e.center - middle).head<2>().array().abs() / (0.5 * kRoom)).maxCoeff());
  std::nth_element(share.begin(), share.begin() + kFilling, share.end());
  return std::max(1.0, 1.0 / share[kFilling]);
}

/// Enlarges a scene that is larger than the room to fill it, and leaves what is about its middle. \returns
/// the box of that.
Eigen::AlignedBox3d crop_to_room(const GaussianScene& scene, SceneConfig& config, const EllipsoidScene& kept,
                                 const Eigen::Vector3d& middle) {
  const double larger = enlarged_to_fill(kept, middle);
  config.registration.scale *= larger;
  const Eigen::Vector3d half(0.5 * kRoom.x(), 0.5 * kRoom.y(), std::numeric_limits<double>::max());
  auto& crop = config.filter.crop_box.emplace(larger * middle - half, larger * middle + half);
  const Eigen::AlignedBox3d box = central_box(kept_of(scene, config));
  crop.min().z() = box.min().z();
  crop.max().z() = box.max().z();
  return box;
}

/// A procedural scene as large as fits, a captured one as large as suits the tool: beside where the handle
/// rests, or the middle of it below. What is too low for the handle is not touched.
void place_in_room(const GaussianScene& scene, SceneConfig& config, double tool_radius,
                   const Eigen::Vector3d& home) {
  const bool captured = scene.format != "procedural";
  Similarity& placed = config.registration = {};
  config.frame = UpAxis::kAsIs;
  if (captured) {
    const SceneSetup proposed = propose_setup(scene, tool_radius);
    config.frame = proposed.frame.value;
    placed.scale = proposed.scale.value;
  }
  const EllipsoidScene kept = kept_of(scene, config);
  Eigen::AlignedBox3d box = central_box(kept);
  if (!captured) {
    placed.scale = (kFits.array() / box.sizes().array()).minCoeff();
    box = {placed.scale * box.min(), placed.scale * box.max()};
  }
  const bool below = (box.sizes().array() > 1.001 * kFits.array()).any() && !config.filter.crop_box;
  if (below) box = crop_to_room(scene, config, kept, box.center());
  const Eigen::Vector3d top =
      below ? Eigen::Vector3d(0.0, 0.0, home.z() - kUnderHandle)
            : Eigen::Vector3d(0.0, -kAside - 0.5 * box.sizes().y(), giant_reach().max().z() - kBelow);
  placed.translation = top - Eigen::Vector3d(box.center().x(), box.center().y(), box.max().z());
  if (below) config.filter.crop_box->translate(placed.translation);
}

Ground ground_of(Options& options, const Eigen::Vector3d& home, const Progress& progress) {
  Ground ground;
  SceneConfig& scene = options.live.scene;
  GaussianScene gaussians;
  if (scene.path.empty()) {
    ground.surface = make_surface("truck");
    report(progress, "making the scene", 0.0);
    gaussians = truck(*ground.surface, options.seed);
    ground.name = "a procedural truck";
  } else {
    gaussians = load(scene, progress).scene;
    ground.name = std::filesystem::path(scene.name()).filename().string();
  }
  const double radius = options.live.tool.thinnest();
  if (!options.registered) place_in_room(gaussians, scene, radius, home);
  const Similarity registration = scene.world_from_scene();
  ground.loaded.scene = std::move(gaussians);
  ground.loaded.kept = filter_scene(ground.loaded.scene, scene.filter, registration, ground.loaded.filtered);
  ground.index = std::make_unique<SceneIndex>(ground.loaded.scene, scene.filter, registration, progress);
  const double reach = PaperPipeline::default_search_radius(ground.loaded.kept, options.live.tool.radius());
  ground.paper = std::make_unique<PaperPipeline>(ground.loaded.kept, reach);
  return ground;
}

std::string setup_text(const Options& options, const Ground& ground) {
  const Similarity& placed = options.live.scene.registration;
  return fmt::format(
      "{}, {} Gaussians, of which {} have an opacity above {:g}; registered into the room with scale {:.4g} "
      "and "
      "translation {:.3f}, {:.3f}, {:.3f} m. A simulated room-scale device of the admittance type ({} "
      "mechanics) in a hand of "
      "{:g} kg, {:g} N s/m and {:g} N/m, 1 kHz, virtual time; tool {}; {} places, seed {}. On the left the "
      "paper's pipeline "
      "with its force (density), on the right this project's defaults. {}",
      ground.name, ground.loaded.filtered.total, ground.loaded.kept.size(),
      options.live.scene.filter.opacity_min, placed.scale, placed.translation.x(), placed.translation.y(),
      placed.translation.z(), options.plant, options.live.device.hand.mass, options.live.device.hand.damping,
      options.live.device.hand.stiffness, tool_text(options.live.tool), options.touches, options.seed,
      machine());
}

ReproductionModel model_of(const Options& options, const Ground& ground, ForceModelKind kind, double stall) {
  ReproductionModel model;
  model.name = to_string(kind);
  model.force = make_force_model(kind, options.live.force, *ground.index, options.live.tool);
  model.contacts = kind == ForceModelKind::kDensity ? ground.paper.get() : nullptr;
  model.stall = stall;
  return model;
}

Provenance provenance_of(const Options& options, const Ground& ground) {
  using enum ConfigGroup;
  SceneOrigin scene{ground.name, {}};
  if (!options.live.scene.path.empty()) scene = scene_origin(options.live.scene);
  return made_by(options.common, scene, options.live, {kScene, kTool, kForce, kDevice, kLoop});
}

void run(Options options) {
  ResultFile csv(options.csv), html(options.html);
  check_figure_folder(options.svg);
  const Progress progress = terminal_progress(options.common.quiet);
  LiveConfig& live = options.live;
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
  report(progress, "looking for places", 0.0);
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
  report(progress, "feeling", 1.0);
  result.claims = claims(ground.loaded.filtered.total, ground.loaded.kept.size(), result.path, result.runs[0],
                         result.runs[1]);
  result.setup = setup_text(options, ground);

  const std::vector<Plot> figures = reproduction_figures(result, ground.loaded.kept);
  std::vector<std::string> written;
  const Provenance made = provenance_of(options, ground);
  if (!options.csv.empty()) csv.write(head_of(made) + reproduction_csv(result), written);
  if (!options.html.empty()) html.write(reproduction_page(result, figures, to_toml(made)), written);
  write_figures(figures, options.svg, "reproduce", written);
  if (options.common.json) {
    Json json = reproduction_json(result);
    json["made"] = made_json(made);
    print_json(json);
  } else if (!options.common.quiet) {
    fmt::print("{}", reproduction_text(result));
    for (const std::string& name : written) fmt::print("wrote {}\n", printable(name));
  }
}

}  // namespace

Command declare_reproduce(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "reproduce", "Repeat the paper's evaluation on a simulated room-scale device");
  auto options = std::make_shared<Options>();
  declare_common(app, options->common, "print all figures as JSON");
  LiveConfig& live = options->live;
  live.tool = Tool(Eigen::Vector3d::Constant(0.03));
  live.device.hand = {0.15, 4.0, 400.0};
  declare_scene(app, live, SceneArgument::kOptionalPositional);
  add_choice(app, "--plant", options->plant, {"own", "mujoco"},
             "mechanics of the device: the project's own, or MuJoCo's");
  add_count(app, "--touches", options->touches, 2, 26, "places that are touched");
  add_number(app, "--press", options->press, 0.001, 0.2, "m",
             "how far beyond first contact the hand wants to go");
  add_number(app, "--stall", options->stall, 0.0, 1.0, "s",
             "the same again with forces that take so long, and are held; 0: not");
  add_seed(app, options->seed, "of the scene and the choice of places");
  for (const char* name : {"tool", "hand", "chain", "virtual-mass", "virtual-damping"})
    declare_field(app, live, name);
  add_text(app, "--csv", options->csv, "T.csv", "every tick of the first two runs");
  add_text(app, "--html", options->html, "P.html", "tables and figures as one self-contained page");
  add_text(app, "--svg", options->svg, "DIR", "a folder, for the figures of the page as files");
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
