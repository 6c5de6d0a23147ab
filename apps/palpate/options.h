/// \file
/// Options shared by several commands.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <palpate/base/progress.h>
#include <palpate/collision/paper_pipeline.h>
#include <palpate/haptics/force_model.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/live_config.h>
#include <palpate/live/live_scene.h>

#include "command.h"
#include "declare.h"

namespace palpate::cli {

inline constexpr int kMostThreads = 1024;  ///< of --threads

/// \name Options of a live configuration, as config_fields() describes them
/// `config` must live until the arguments are parsed; what it holds is the default.
/// @{
/// The option of that name, under the heading of its group.
DeclaredOption declare_field(CLI::App& app, LiveConfig& config, std::string_view name);
/// All of a group.
void declare_group(CLI::App& app, LiveConfig& config, ConfigGroup group);
/// The scene as positional argument SCENE, which may be optional, or as option --scene; and its group but for
/// --no-index-file.
enum class SceneArgument { kPositional, kOptionalPositional, kOption };
void declare_scene(CLI::App& app, LiveConfig& config, SceneArgument as);
/// The group of forces but for --model and --materials.
void declare_force_parameters(CLI::App& app, LiveConfig& config);
/// @}

/// Loads and filters; warns on stderr if nothing is left. \throws Error.
LoadedScene load(const SceneConfig& config, const Progress& progress);

/// Contact query pipeline: exactly one of the two is set.
struct Pipeline {
  std::unique_ptr<SceneIndex> index;     ///< the exact one
  std::unique_ptr<PaperPipeline> paper;  ///< the paper's

  const ContactQuery& query() const { return index ? static_cast<const ContactQuery&>(*index) : *paper; }
};

/// Options of contact query and force model.
struct QueryOptions {
  std::string pipeline = "exact";
  std::optional<double> search_radius;
  int iterations = PaperPipeline::kDefaultIterations;

  void declare(CLI::App& app, LiveConfig& config);

  bool is_exact() const { return pipeline == "exact"; }
  /// \throws Error.
  Pipeline build(const LiveConfig& config, const Progress& progress) const;
  /// The model that was asked for; else the proxy, or the paper's on the contacts of the paper's pipeline.
  ForceModelKind model(const LiveConfig& config) const;
  /// Of model(), for the contacts of `pipeline`, which must outlive it. \throws Error if the model needs a
  /// SceneIndex and has none, or for broken materials.
  std::unique_ptr<ForceModel> build_model(const LiveConfig& config, const Pipeline& of,
                                          const Progress& progress) const;

 private:
  const CLI::App* app_ = nullptr;  ///< which lives as long as the program
};

}  // namespace palpate::cli
