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
#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/haptics/material_file.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/scene/load_scene.h>

#include "output.h"

namespace palpate::cli {
namespace {

constexpr const char* kSceneGroup = "Scene";
constexpr const char* kToolGroup = "Tool";
constexpr const char* kForceGroup = "Force";

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

double parse_number(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (text.empty() || error != std::errc{} || end != text.end() || !std::isfinite(value)) {
    throw CLI::ValidationError(fmt::format("'{}' is not a finite number", text));
  }
  return value;
}

Eigen::Quaterniond parse_quaternion(const double* wxyz) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(q.norm() > 1e-6 && q.norm() < 1e6)) {
    throw CLI::ValidationError("the quaternion qw,qx,qy,qz must not be zero");
  }
  return q.normalized();
}

void declare_crops(CLI::App& app, SceneFilter& filter) {
  add_parsed(app, "--crop-box", "x0,y0,z0,x1,y1,z1", "keep centres inside this box, world frame, m",
             [&filter](const std::string& text) {
               const auto v = parse_numbers(text, 6, 6);
               const Eigen::AlignedBox3d box(Eigen::Vector3d(v[0], v[1], v[2]),
                                             Eigen::Vector3d(v[3], v[4], v[5]));
               if (box.isEmpty()) throw CLI::ValidationError("the first corner must be below the second");
               filter.crop_box = box;
             })
      ->group(kSceneGroup);
  add_parsed(app, "--crop-sphere", "x,y,z,r", "keep centres inside this sphere, world frame, m",
             [&filter](const std::string& text) {
               const auto v = parse_numbers(text, 4, 4);
               if (!(v[3] > 0.0)) throw CLI::ValidationError("the radius must be positive");
               filter.crop_sphere = SceneFilter::Sphere{{v[0], v[1], v[2]}, v[3]};
             })
      ->group(kSceneGroup);
}

void declare_registration(CLI::App& app, SceneOptions& options) {
  std::vector<std::string> names;
  for (const auto& entry : frames()) names.push_back(entry.first);
  app.add_option("--frame", options.frame, "which captured axis points up; it becomes world +z")
      ->check(CLI::IsMember(names))
      ->capture_default_str()
      ->group(kSceneGroup);
  add_number(app, "--scale", options.registration.scale, kMinScale, kMaxScale, "m/unit",
             "metres per captured unit")
      ->group(kSceneGroup);
  add_parsed(app, "--rotate", "qw,qx,qy,qz", "rotation from the captured frame to the world",
             [&options](const std::string& text) {
               options.registration.rotation = parse_quaternion(parse_numbers(text, 4, 4).data());
             })
      ->group(kSceneGroup);
  add_vector3(app, "--translate", options.registration.translation, "m",
              "translation, after scale and rotation")
      ->group(kSceneGroup);
}

}  // namespace

std::vector<double> parse_numbers(const std::string& text, std::size_t min_count, std::size_t max_count) {
  std::vector<double> numbers;
  std::string_view rest = text;
  for (;;) {
    const std::size_t comma = rest.find(',');
    numbers.push_back(parse_number(rest.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (numbers.size() < min_count || numbers.size() > max_count) {
    throw CLI::ValidationError(
        fmt::format("'{}' has {} numbers; {} are needed", text, numbers.size(), min_count));
  }
  return numbers;
}

CLI::Option* add_parsed(CLI::App& app, const std::string& name, const std::string& type,
                        const std::string& description, const std::function<void(const std::string&)>& set) {
  const auto callback = [name, set](const CLI::results_t& results) {
    try {
      set(results.front());
    } catch (const CLI::ValidationError& error) {
      throw CLI::ValidationError(name, error.what());
    }
    return true;
  };
  CLI::Option* option = app.add_option(name, callback, description);
  return option->type_name(type)->type_size(1)->expected(1);
}

CLI::Option* add_number(CLI::App& app, const std::string& name, double& value, double low, double high,
                        const std::string& unit, const std::string& description) {
  const auto set = [&value, low, high](const std::string& text) {
    const double number = parse_number(text);
    if (!(number >= low && number <= high)) {
      throw CLI::ValidationError(fmt::format("{} is not in {} to {}", text, low, high));
    }
    value = number;
  };
  return add_parsed(app, name, unit, description, set)->default_str(fmt::format("{}", value));
}

CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description) {
  const auto set = [&seed](const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
      throw CLI::ValidationError(fmt::format("'{}' is not a whole number from 0 to 2^64-1", text));
    }
    seed = value;
  };
  return add_parsed(app, "--seed", "n", description, set)->default_str(fmt::format("{}", seed));
}

CLI::Option* add_vector3(CLI::App& app, const std::string& name, Eigen::Vector3d& value,
                         const std::string& unit, const std::string& description) {
  const auto set = [&value](const std::string& text) {
    const auto v = parse_numbers(text, 3, 3);
    value = {v[0], v[1], v[2]};
  };
  return add_parsed(app, name, "x,y,z", description + ", " + unit, set)
      ->default_str(fmt::format("{},{},{}", value.x(), value.y(), value.z()));
}

double parse_positive(const std::string& text) {
  const double value = parse_number(text);
  if (!(value > 0.0)) throw CLI::ValidationError(text + " is not positive");
  return value;
}

Pose parse_pose(const std::string& text) {
  const auto v = parse_numbers(text, 3, 7);
  if (v.size() != 3 && v.size() != 7) {
    throw CLI::ValidationError(fmt::format("'{}' has {} numbers; 3 or 7 are needed", text, v.size()));
  }
  Pose pose;
  pose.position = {v[0], v[1], v[2]};
  if (pose.position.cwiseAbs().maxCoeff() > kMaxExtent) {
    throw CLI::ValidationError(fmt::format("'{}' is more than {} m away", text, kMaxExtent));
  }
  if (v.size() == 7) pose.orientation = parse_quaternion(v.data() + 3);
  return pose;
}

void SceneOptions::declare(CLI::App& app, As as) {
  const bool positional = as == As::kPositional;
  CLI::Option* scene = app.add_option(positional ? "SCENE" : "--scene", path, "3DGS scene, .ply or .splat");
  if (positional) scene->required();

  add_number(app, "--opacity-min", filter.opacity_min, 0.0, 1.0, "alpha",
             "keep Gaussians of opacity above this")
      ->group(kSceneGroup);
  CLI::Option* sigma = add_number(app, "--sigma", filter.sigma, 1e-6, 1e3, "k",
                                  "ellipsoid of a Gaussian: k standard deviations")
                           ->group(kSceneGroup);
  add_parsed(app, "--iso", "tau", "ellipsoid at the visible level instead: k = sqrt(2 ln(alpha/tau))",
             [this](const std::string& text) {
               const double tau = parse_number(text);
               if (!(tau > 0.0 && tau < 1.0)) throw CLI::ValidationError(text + " is not between 0 and 1");
               filter.iso = tau;
             })
      ->excludes(sigma)
      ->group(kSceneGroup);
  add_parsed(app, "--max-scale", "m", "drop Gaussians whose longest standard deviation is above this, m",
             [this](const std::string& text) { filter.max_scale = parse_positive(text); })
      ->group(kSceneGroup);
  declare_crops(app, filter);
  declare_registration(app, *this);
}

Similarity SceneOptions::world_from_scene() const {
  Similarity result = registration;
  result.rotation = registration.rotation * frames().at(frame);
  return result;
}

std::string SceneOptions::frame_note() const {
  if (frame != "as-is") return fmt::format("captured frame taken as {}, turned to world z up", frame);
  return "no frame is declared in the file: captured axes are taken as world axes, z up (see --frame)";
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

}  // namespace

LoadedScene load(const SceneOptions& options, const Progress& progress) {
  LoadedScene result;
  result.scene = load_scene(options.path, progress);
  result.kept =
      filter_scene(result.scene, options.filter, options.world_from_scene(), result.filtered, progress);
  tell(result.filtered, options.path);
  return result;
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
    if (text.ends_with(".toml")) {
      tool = read_tool(text);
      return;
    }
    const auto v = parse_numbers(text, 3, 3);
    for (const double a : v) {
      if (!(a >= kMinToolAxis && a <= kMaxToolAxis)) {
        throw CLI::ValidationError(
            fmt::format("semi-axis {} is not in {} to {} m", a, kMinToolAxis, kMaxToolAxis));
      }
    }
    tool = Tool({v[0], v[1], v[2]});
  };
  const Eigen::Vector3d& a = tool.parts()[0].semi_axes;
  add_parsed(app, "--tool", "a,b,c|FILE.toml",
             "semi-axes of an ellipsoid, m; or a file of many, as in examples/tools", set)
      ->default_str(fmt::format("{},{},{}", a.x(), a.y(), a.z()))
      ->group(kToolGroup);
}

void QueryOptions::declare_pipeline(CLI::App& app) {
  CLI::Option* choice =
      app.add_option("--pipeline", pipeline, "exact, or the paper's kd-tree and golden section");
  choice->check(CLI::IsMember({"exact", "paper"}))->capture_default_str()->group(kToolGroup);
  app.add_flag("--no-index-file", no_index_file,
               "neither read nor write SCENE.palpate, the index beside the scene")
      ->group(kToolGroup);
  add_parsed(app, "--search-radius", "m", "of the paper's kd-tree (default: reaches 99 % of the Gaussians)",
             [this](const std::string& text) { search_radius = parse_positive(text); })
      ->group(kToolGroup);
  app.add_option("--iterations", iterations, "of the paper's golden section")
      ->check(CLI::Range(1, 200))
      ->capture_default_str()
      ->group(kToolGroup);
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

void ForceOptions::declare(CLI::App& app) {
  app.add_option("--model", model,
                 "force model: proxy follows the surface; field is the gradient of a potential; density is "
                 "the paper's")
      ->check(CLI::IsMember({"proxy", "field", "density"}))
      ->default_str("proxy; density with --pipeline paper")
      ->group(kForceGroup);
  app.add_option("--materials", materials, "of proxy: what the scene is made of, region by region")
      ->type_name("FILE.toml")
      ->group(kForceGroup);
  declare_parameters(app);
}

void ForceOptions::declare_parameters(CLI::App& app) {
  constexpr double kMost = 1e6;
  add_number(app, "--stiffness", proxy.stiffness, 0.0, kMaterialProperties[kMaterialStiffness].most, "N/m",
             "of proxy and field: force per depth")
      ->group(kForceGroup);
  add_number(app, "--friction", proxy.friction, 0.0, kMaterialProperties[kMaterialFriction].most, "1",
             "of proxy: Coulomb's coefficient")
      ->group(kForceGroup);
  add_parsed(app, "--detail", "m",
             "of proxy: what is smaller is smoothed away (default: 0.6 of the tool's thinnest semi-axis)",
             [this](const std::string& text) { proxy.detail = parse_positive(text); })
      ->group(kForceGroup);
  add_number(app, "--k-base", density.k_base, 0.0, kMost, "N",
             "eq. 9: force of one colliding Gaussian of opacity 1")
      ->group(kForceGroup);
  add_number(app, "--damping", density.damping, 0.0, kMost, "N.s/m", "eq. 10: D")->group(kForceGroup);
  add_number(app, "--f-max", density.f_max, 0.0, kMost, "N", "eq. 11: F_max")->group(kForceGroup);
  add_number(app, "--tau-direction", density.tau_direction, 0.0, kMost, "s",
             "time constant of the direction average")
      ->group(kForceGroup);
  add_number(app, "--tau-opacity", density.tau_opacity, 0.0, kMost, "s",
             "time constant of the opacity average")
      ->group(kForceGroup);
  add_number(app, "--tau-velocity", density.tau_velocity, 0.0, kMost, "s",
             "time constant of the velocity filter")
      ->group(kForceGroup);
}

std::string ForceOptions::model_for(const ContactQuery& query) const {
  if (!model.empty()) return model;
  return dynamic_cast<const SceneIndex*>(&query) != nullptr ? "proxy" : "density";
}

std::unique_ptr<ForceModel> ForceOptions::build(const ContactQuery& query, const Tool& tool,
                                                const std::string& scene, const Progress& progress) const {
  const std::string name = model_for(query);
  if (name == "density") return std::make_unique<DensityForce>(tool, density);
  if (name == "field") return std::make_unique<FieldForce>(tool, FieldParameters{proxy.stiffness});
  const auto* index = dynamic_cast<const SceneIndex*>(&query);
  if (index == nullptr) {
    throw Error(
        "--model proxy asks for contacts by itself, as --pipeline exact finds them; take that, or --model "
        "density");
  }
  ProxyParameters parameters = proxy;
  parameters.materials = std::make_shared<MaterialMap>(
      materials.empty() ? std::vector<MaterialRegion>{} : read_materials(materials),
      scene.empty() ? PlyMaterials{} : read_ply_materials(scene, progress));
  return std::make_unique<ProxyForce>(*index, tool, parameters);
}

}  // namespace palpate::cli
