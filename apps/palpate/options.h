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
#include <palpate/report/result_files.h>

#include "command.h"
#include "declare.h"

namespace palpate::cli {

inline constexpr int kMostThreads = 1024;  ///< upper limit of --threads

/// \name Options of a live configuration, as config_fields() describes them
/// `config` must live until the arguments are parsed; its initial values are the defaults.
/// @{
/// Declares the option of that name, under the heading of its group.
DeclaredOption declare_field(CLI::App& app, LiveConfig& config, std::string_view name);
/// Declares all options of a group but --no-index-file.
void declare_group(CLI::App& app, LiveConfig& config, ConfigGroup group);
/// How the scene is given: positional argument SCENE, required or optional, or option --scene.
enum class SceneArgument { kPositional, kOptionalPositional, kOption };
/// Declares the scene argument and the options of its group.
void declare_scene(CLI::App& app, LiveConfig& config, SceneArgument as);
/// Declares the options of the force group but --model and --materials.
void declare_force_parameters(CLI::App& app, LiveConfig& config);
/// @}

/// Declares --csv, --html and --svg of a command that measures. \param csv help of --csv
void declare_results(CLI::App& app, ResultNames& names, const std::string& csv);

/// Loads and filters a scene; warns on stderr if no Gaussian is left. \throws Error.
LoadedScene load(const SceneConfig& config, const Progress& progress);

/// Contact query pipeline; exactly one member is set.
struct Pipeline {
  std::unique_ptr<SceneIndex> index;     ///< exact pipeline
  std::unique_ptr<PaperPipeline> paper;  ///< the paper's pipeline

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
  /// The requested model; by default that of `config` for the exact pipeline, density for the paper's.
  ForceModelKind model(const LiveConfig& config) const;
  /// Builds model() for the contacts of `of`, which must outlive it. \throws Error if the model needs a
  /// SceneIndex and has none, or for broken materials.
  std::unique_ptr<ForceModel> build_model(const LiveConfig& config, const Pipeline& of,
                                          const Progress& progress) const;

 private:
  const CLI::App* app_ = nullptr;  ///< lives as long as the program
};

}  // namespace palpate::cli
