#include "options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/haptics/material_file.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/scene/load_scene.h>
#include <palpate/study/procedural.h>

#include "output.h"

namespace palpate::cli {
namespace {

constexpr const char* kSceneGroup = "Scene";
constexpr const char* kToolGroup = "Tool";
constexpr const char* kForceGroup = "Force";

/// The scene that is there without a file.
constexpr const char* kBuiltIn = "table";

/// Bounds on user-given sizes that keep every product of the contact mathematics inside a double.
constexpr double kMinScale = 1e-9;
constexpr double kMaxScale = 1e9;

/// Captured axes that may point up, as rotations that turn that axis to world +z.
const std::map<std::string, Eigen::Quaterniond>& frames() {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  constexpr double kQuarter = std::numbers::pi / 2;
  static const std::map<std::string, Eigen::Quaterniond> table{
      {"as-is", Eigen::Quaterniond::Identity()},
      {"z-up", Eigen::Quaterniond::Identity()},
      {"z-down", Eigen::Quaterniond(0, 1, 0, 0)},
      {"y-up", Eigen::Quaterniond(AngleAxisd(kQuarter, Vector3d::UnitX()))},
      {"y-down", Eigen::Quaterniond(AngleAxisd(-kQuarter, Vector3d::UnitX()))},
      {"x-up", Eigen::Quaterniond(AngleAxisd(-kQuarter, Vector3d::UnitY()))},
      {"x-down", Eigen::Quaterniond(AngleAxisd(kQuarter, Vector3d::UnitY()))}};
  return table;
}

void declare_crops(CLI::App& app, SceneFilter& filter) {
  add_parsed(app, "--crop-box", "x0,y0,z0,x1,y1,z1", "keep centres inside this box, world frame, m",
             [&filter](const std::string& text) {
               const auto v = parse_numbers(text, 6, 6);
               const Eigen::AlignedBox3d box(Eigen::Vector3d(v[0], v[1], v[2]),
                                             Eigen::Vector3d(v[3], v[4], v[5]));
               if (box.isEmpty()) throw BadValue("the first corner must be below the second");
               filter.crop_box = box;
             })
      .in_group(kSceneGroup);
  add_parsed(app, "--crop-sphere", "x,y,z,r", "keep centres inside this sphere, world frame, m",
             [&filter](const std::string& text) {
               const auto v = parse_numbers(text, 4, 4);
               if (!(v[3] > 0.0)) throw BadValue("the radius must be positive");
               filter.crop_sphere = SceneFilter::Sphere{{v[0], v[1], v[2]}, v[3]};
             })
      .in_group(kSceneGroup);
}

void declare_registration(CLI::App& app, SceneOptions& options) {
  add_choice(app, "--frame", options.frame, frame_names(),
             "which captured axis points up; it becomes world +z")
      .in_group(kSceneGroup);
  add_flag(app, "--mirror", options.registration.mirrored,
           "the capture is a mirror image: reverse its x axis, before --frame")
      .in_group(kSceneGroup);
  add_number(app, "--scale", options.registration.scale, kMinScale, kMaxScale, "m/unit",
             "metres per captured unit")
      .in_group(kSceneGroup);
  add_parsed(app, "--rotate", "qw,qx,qy,qz", "rotation from the captured frame to the world",
             [&options](const std::string& text) {
               options.registration.rotation = parse_quaternion(parse_numbers(text, 4, 4).data());
             })
      .in_group(kSceneGroup);
  add_vector3(app, "--translate", options.registration.translation, "m",
              "translation, after scale and rotation")
      .in_group(kSceneGroup);
}

}  // namespace

std::vector<std::string> frame_names() {
  std::vector<std::string> names;
  for (const auto& entry : frames()) names.push_back(entry.first);
  return names;
}

void SceneOptions::declare(CLI::App& app, As as) {
  const bool positional = as != As::kOption;
  DeclaredOption scene =
      add_text(app, positional ? "SCENE" : "--scene", path, "", "3DGS scene, .ply or .splat");
  if (as == As::kPositional) scene.required();

  add_number(app, "--opacity-min", filter.opacity_min, 0.0, 1.0, "alpha",
             "keep Gaussians of opacity above this")
      .in_group(kSceneGroup);
  const DeclaredOption sigma = add_number(app, "--sigma", filter.sigma, 1e-6, SceneFilter::kSigmaMax, "k",
                                          "ellipsoid of a Gaussian: k standard deviations")
                                   .in_group(kSceneGroup);
  add_parsed(app, "--iso", "tau", "ellipsoid at the visible level instead: k = sqrt(2 ln(alpha/tau))",
             [this](const std::string& text) {
               const double tau = parse_number(text);
               if (!(tau > 0.0 && tau < 1.0)) throw BadValue(text + " is not between 0 and 1");
               filter.iso = tau;
             })
      .excludes(sigma)
      .in_group(kSceneGroup);
  add_parsed(app, "--max-scale", "m", "drop Gaussians whose longest standard deviation is above this, m",
             [this](const std::string& text) { filter.max_scale = parse_positive(text); })
      .in_group(kSceneGroup);
  declare_crops(app, filter);
  declare_registration(app, *this);
}

Similarity SceneOptions::world_from_scene() const {
  Similarity result = registration;
  result.rotation = registration.rotation * frames().at(frame);
  return result;
}

std::string SceneOptions::name() const {
  return path.empty() ? fmt::format("the built-in {}", kBuiltIn) : path;
}

std::string SceneOptions::frame_note() const {
  const char* mirror = registration.mirrored ? ", its x axis reversed" : "";
  if (frame != "as-is")
    return fmt::format("captured frame taken as {}{}, turned to world z up", frame, mirror);
  return fmt::format(
      "no frame is declared in the file: captured axes are taken as world axes{}, z up (see --frame)",
      mirror);
}

namespace {

/// Says what the filter dropped that a person should know of.
void tell(const FilterReport& f, const std::string& path) {
  if (f.kept == 0) {
    notify(fmt::format(
        "warning: {}: nothing is left to touch: of {} Gaussians {} are defective, {} below "
        "--opacity-min, {} below --iso, {} above --max-scale, {} outside the crop",
        path, f.total, f.defective(), f.low_opacity, f.below_iso, f.over_max_scale, f.outside_crop));
  } else if (f.defective() != 0) {
    notify(fmt::format("note: {}: {} of {} Gaussians cannot collide and are left out (see palpate info)",
                       path, f.defective(), f.total));
  }
}

LoadedScene filtered(GaussianScene scene, const SceneOptions& options, const Progress& progress) {
  LoadedScene result;
  result.scene = std::move(scene);
  result.kept =
      filter_scene(result.scene, options.filter, options.world_from_scene(), result.filtered, progress);
  tell(result.filtered, options.name());
  return result;
}

}  // namespace

LoadedScene load(const SceneOptions& options, const Progress& progress) {
  return filtered(load_scene(options.path, progress), options, progress);
}

LoadedScene load_or_make(const SceneOptions& options, const Progress& progress) {
  return options.path.empty() ? filtered(make_scene(*make_surface(kBuiltIn), {}), options, progress)
                              : load(options, progress);
}

SceneIndex open_index(const SceneOptions& options, IndexFiles files, const Progress& progress) {
  const OpenedIndex opened =
      palpate::open_index(options.path, options.filter, options.world_from_scene(), files, progress);
  if (opened.rejected) notify(fmt::format("note: {}; made again", *opened.rejected));
  if (opened.not_written) {
    notify(fmt::format("warning: {}; the index is in memory, and made again by every command",
                       *opened.not_written));
  }
  if (opened.origin == OpenedIndex::Origin::kNewFile && progress) {  // someone watches
    notify(fmt::format("note: wrote {}, which the next command starts from", index_path(options.path)));
  }
  tell(opened.report, options.path);
  return opened.index;
}

void QueryOptions::declare_tool(CLI::App& app) {
  const auto set = [this](const std::string& text) {
    if (text.starts_with("[[")) {
      tool = parse_tool("--tool", text);
      return;
    }
    if (text.ends_with(".toml")) {
      tool = read_tool(text);
      return;
    }
    const auto v = parse_numbers(text, 3, 3);
    for (const double a : v) {
      if (!(a >= kMinToolAxis && a <= kMaxToolAxis)) {
        throw BadValue(fmt::format("semi-axis {} is not in {} to {} m", a, kMinToolAxis, kMaxToolAxis));
      }
    }
    tool = Tool({v[0], v[1], v[2]});
  };
  const Eigen::Vector3d& a = tool.parts()[0].semi_axes;
  add_parsed(app, "--tool", "a,b,c|FILE.toml",
             "semi-axes of an ellipsoid, m; or a file of many, as in examples/tools, or its text", set)
      .shows_default(fmt::format("{},{},{}", a.x(), a.y(), a.z()))
      .in_group(kToolGroup);
}

void QueryOptions::declare_pipeline(CLI::App& app) {
  add_choice(app, "--pipeline", pipeline, {"exact", "paper"},
             "exact, or the paper's kd-tree and golden section")
      .in_group(kToolGroup);
  add_flag(app, "--no-index-file", no_index_file,
           "neither read nor write SCENE.palpate, the index beside the scene")
      .in_group(kToolGroup);
  add_parsed(app, "--search-radius", "m", "of the paper's kd-tree (default: reaches 99 % of the Gaussians)",
             [this](const std::string& text) { search_radius = parse_positive(text); })
      .in_group(kToolGroup);
  add_count(app, "--iterations", iterations, 1, 200, "of the paper's golden section").in_group(kToolGroup);
}

std::unique_ptr<ContactQuery> QueryOptions::build(const SceneOptions& options,
                                                  const Progress& progress) const {
  if (pipeline == "exact") {
    const IndexFiles files = no_index_file ? IndexFiles::kNone : IndexFiles::kUse;
    return std::make_unique<SceneIndex>(open_index(options, files, progress));
  }
  EllipsoidScene scene = load(options, progress).kept;
  const double radius = search_radius.value_or(PaperPipeline::default_search_radius(scene, tool.longest()));
  return std::make_unique<PaperPipeline>(std::move(scene), radius, iterations);
}

HandProperties parse_hand(const double* mbk) {
  if (std::any_of(mbk, mbk + 3, [](double v) { return v < 0.0; })) throw BadValue("none may be below zero");
  return {mbk[0], mbk[1], mbk[2]};
}

void ForceOptions::declare(CLI::App& app) {
  add_choice(
      app, "--model", model, {kModels.begin(), kModels.end()},
      "force model: proxy follows the surface; field is the gradient of a potential; density is the paper's")
      .shows_default("proxy; density with --pipeline paper")
      .in_group(kForceGroup);
  add_text(app, "--materials", materials, "FILE.toml",
           "of proxy: what the scene is made of, region by region")
      .in_group(kForceGroup);
  declare_parameters(app);
}

void ForceOptions::declare_parameters(CLI::App& app) {
  constexpr double kMost = 1e6;
  add_number(app, "--stiffness", proxy.stiffness, 0.0, kMaterialProperties[kMaterialStiffness].most, "N/m",
             "of proxy and field: force per depth")
      .in_group(kForceGroup);
  add_number(app, "--friction", proxy.friction, 0.0, kMaterialProperties[kMaterialFriction].most, "1",
             "of proxy: Coulomb's coefficient")
      .in_group(kForceGroup);
  add_parsed(app, "--detail", "m",
             "of proxy: what is smaller is smoothed away (default: 0.65 of the tool's thinnest semi-axis)",
             [this](const std::string& text) { proxy.detail = parse_positive(text); })
      .in_group(kForceGroup);
  add_number(app, "--k-base", density.k_base, 0.0, kMost, "N",
             "eq. 9: force of one colliding Gaussian of opacity 1")
      .in_group(kForceGroup);
  add_number(app, "--damping", density.damping, 0.0, kMost, "N.s/m", "eq. 10: D").in_group(kForceGroup);
  add_number(app, "--f-max", density.f_max, 0.0, kMost, "N", "eq. 11: F_max").in_group(kForceGroup);
  add_number(app, "--tau-direction", density.tau_direction, 0.0, kMost, "s",
             "time constant of the direction average")
      .in_group(kForceGroup);
  add_number(app, "--tau-opacity", density.tau_opacity, 0.0, kMost, "s",
             "time constant of the opacity average")
      .in_group(kForceGroup);
  add_number(app, "--tau-velocity", density.tau_velocity, 0.0, kMost, "s",
             "time constant of the velocity filter")
      .in_group(kForceGroup);
}

std::string ForceOptions::model_for(const ContactQuery& query) const {
  if (!model.empty()) return model;
  return dynamic_cast<const SceneIndex*>(&query) != nullptr ? "proxy" : "density";
}

ForceOptions::Materials ForceOptions::made_of(const std::string& scene, const Progress& progress) const {
  return std::make_shared<MaterialMap>(
      materials.empty() ? std::vector<MaterialRegion>{} : read_materials(materials),
      scene.empty() ? PlyMaterials{} : read_ply_materials(scene, progress));
}

std::unique_ptr<ForceModel> ForceOptions::build(const ContactQuery& query, const Tool& tool,
                                                const std::string& scene, const Progress& progress) const {
  const std::string name = model_for(query);
  const auto* index = dynamic_cast<const SceneIndex*>(&query);
  if (index != nullptr)
    return build(name, *index, tool, name == "proxy" ? made_of(scene, progress) : nullptr);
  if (name == "density") return std::make_unique<DensityForce>(tool, density);
  if (name == "field") return std::make_unique<FieldForce>(tool, FieldParameters{proxy.stiffness});
  throw Error(
      "--model proxy asks for contacts by itself, as --pipeline exact finds them; take that, or --model "
      "density");
}

std::unique_ptr<ForceModel> ForceOptions::build(const std::string& name, const SceneIndex& index,
                                                const Tool& tool, Materials made_of,
                                                Lookahead* lookahead) const {
  if (name == "density") return std::make_unique<DensityForce>(tool, density);
  if (name == "field") return std::make_unique<FieldForce>(tool, FieldParameters{proxy.stiffness});
  ProxyParameters parameters = proxy;
  parameters.materials = std::move(made_of);
  return std::make_unique<ProxyForce>(index, tool, parameters, lookahead);
}

}  // namespace palpate::cli
