#include "options.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/live/factories.h>

#include "output.h"

namespace palpate::cli {
namespace {

constexpr const char* kModel = "model";
constexpr const char* kMaterials = "materials";
constexpr const char* kPipeline = "pipeline";
constexpr const char* kNoIndexFile = "no-index-file";

/// Declares the option of a field, type by type.
struct Declaration {
  CLI::App& app;
  LiveConfig& config;
  const ConfigField& field;
  std::string name = "--" + std::string(field.name);
  std::string unit = std::string(field.unit);
  std::string help = std::string(field.help);

  DeclaredOption operator()(const FlagField& flag) const {
    return add_flag(app, name, flag.member(config), help);
  }
  DeclaredOption operator()(const CountField& count) const {
    return add_count(app, name, count.member(config), count.least, count.most, help);
  }
  DeclaredOption operator()(const TextField& text) const {
    return text.problem == nullptr ? add_text(app, name, text.member(config), unit, help) : parsed();
  }
  DeclaredOption operator()(const ChoiceField& choice) const {
    const std::vector<std::string> names(choice.names.begin(), choice.names.end());
    if (choice.may_be == nullptr) return add_choice(app, name, names, help, setter());
    // Only a device may be something else. The refusal names those forms, too.
    const auto set = [names, may_be = choice.may_be, set = setter()](const std::string& text) {
      if (std::find(names.begin(), names.end(), text) == names.end() && !may_be(text)) {
        throw BadValue(
            fmt::format("{} is not one of {}, nor a driver: plugin:PATH.so, ros1:/NAME or ros2:/NAME", text,
                        fmt::join(names, ", ")));
      }
      set(text);
    };
    return add_parsed(app, name, fmt::format("TEXT:{{{}}}", fmt::join(names, ",")), help, set);
  }
  template <class Other>
  DeclaredOption operator()(const Other&) const {
    return parsed();
  }

  DeclaredOption parsed() const { return add_parsed(app, name, unit, help, setter()); }
  std::function<void(const std::string&)> setter() const {
    return [&target = config, &of = field](const std::string& text) { set_from_text(of, target, text); };
  }
};

/// Returns whether a command has declared --pipeline: QueryOptions::declare().
bool has_pipelines(const CLI::App& app) {
  const auto options = other_options(app);
  return std::any_of(options.begin(), options.end(),
                     [](const auto& option) { return option.first == kPipeline; });
}

DeclaredOption declare(CLI::App& app, LiveConfig& config, const ConfigField& field) {
  DeclaredOption option = std::visit(Declaration{app, config, field}, field.type);
  option.in_group(std::string(title(field.group)));
  std::string text = default_text(field, config);
  // The field's own text describes the defaults of both pipelines.
  if (field.name == kModel && !has_pipelines(app)) text = to_string(config.force.model);
  if (!text.empty()) option.shows_default(text);
  return option;
}

}  // namespace

DeclaredOption declare_field(CLI::App& app, LiveConfig& config, std::string_view name) {
  return declare(app, config, config_field(name));
}

void declare_group(CLI::App& app, LiveConfig& config, ConfigGroup group) {
  std::vector<std::pair<std::string_view, DeclaredOption>> declared;
  for (const ConfigField& field : config_fields()) {
    if (field.group != group || field.name.empty() || field.name == kNoIndexFile) continue;
    DeclaredOption option = declare(app, config, field);
    for (const auto& [name, other] : declared) {
      if (name == field.traits.excludes) option.excludes(other);
    }
    declared.emplace_back(field.name, option);
  }
}

void declare_scene(CLI::App& app, LiveConfig& config, SceneArgument as) {
  const bool positional = as != SceneArgument::kOption;
  DeclaredOption scene =
      add_text(app, positional ? "SCENE" : "--scene", config.scene.path, "", "3DGS scene, .ply or .splat");
  if (as == SceneArgument::kPositional) scene.required();
  declare_group(app, config, ConfigGroup::kScene);
  if (as != SceneArgument::kOption) return;
  for (const ConfigField& field : config_fields()) {
    if (field.group == ConfigGroup::kScene && !field.name.empty() && field.name != kNoIndexFile)
      need(app, {"--" + std::string(field.name)}, "--scene");
  }
}

void declare_force_parameters(CLI::App& app, LiveConfig& config) {
  for (const ConfigField& field : config_fields()) {
    if (field.group == ConfigGroup::kForce && field.name != kModel && field.name != kMaterials)
      declare(app, config, field);
  }
}

void declare_results(CLI::App& app, ResultNames& names, const std::string& csv) {
  add_text(app, "--csv", names.csv, "T.csv", csv);
  add_text(app, "--html", names.html, "P.html", "tables and figures as one self-contained page");
  add_text(app, "--svg", names.svg, "DIR", "existing folder for the figures of the page as SVG files");
}

LoadedScene load(const SceneConfig& config, const Progress& progress) {
  return load_scene(config, notify, progress);
}

void QueryOptions::declare(CLI::App& app, LiveConfig& config) {
  app_ = &app;
  const std::string group(title(ConfigGroup::kTool));
  add_choice(app, fmt::format("--{}", kPipeline), pipeline, {"exact", "paper"},
             "contact search: exact, or the paper's kd-tree and golden-section search")
      .in_group(group);
  declare_field(app, config, kNoIndexFile).in_group(group);
  add_parsed(app, "--search-radius", "m",
             "paper: search radius of the kd-tree (default: reaches 99 % of the Gaussians)",
             [this](const std::string& text) { search_radius = parse_positive(text); })
      .in_group(group);
  add_count(app, "--iterations", iterations, 1, 200, "paper: iterations of the golden-section search")
      .in_group(group);
}

Pipeline QueryOptions::build(const LiveConfig& config, const Progress& progress) const {
  if (is_exact()) {
    const IndexFiles files = config.scene.no_index_file ? IndexFiles::kNone : IndexFiles::kUse;
    return {std::make_unique<SceneIndex>(open_or_make_index(config.scene, files, notify, progress)), nullptr};
  }
  EllipsoidScene scene = load_or_make_scene(config.scene, notify, progress).kept;
  const double radius =
      search_radius.value_or(PaperPipeline::default_search_radius(scene, config.tool.longest()));
  return {nullptr, std::make_unique<PaperPipeline>(std::move(scene), radius, iterations)};
}

ForceModelKind QueryOptions::model(const LiveConfig& config) const {
  return is_exact() || is_given(*app_, "--model") ? config.force.model : ForceModelKind::kDensity;
}

std::unique_ptr<ForceModel> QueryOptions::build_model(const LiveConfig& config, const Pipeline& of,
                                                      const Progress& progress) const {
  const ForceModelKind kind = model(config);
  if (!of.index) return make_force_model(kind, config.force, config.tool);
  const bool proxy = kind == ForceModelKind::kProxy;
  return make_force_model(kind, config.force, *of.index, config.tool,
                          proxy ? load_materials(config.force, config.scene.path, progress) : nullptr);
}

}  // namespace palpate::cli
