/// \file
/// Options that several commands share.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/base/progress.h>
#include <palpate/collision/open_index.h>
#include <palpate/collision/paper_pipeline.h>
#include <palpate/collision/scene_index.h>
#include <palpate/device/simulated_device.h>
#include <palpate/geometry/similarity.h>
#include <palpate/haptics/density_force.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>

#include "command.h"
#include "declare.h"

namespace palpate::cli {

inline constexpr int kMostThreads = 1024;  ///< of --threads

/// The force models, the default first.
inline constexpr std::array kModels{"proxy", "field", "density"};

/// Which scene, which of its Gaussians, how large, and where.
struct SceneOptions {
  std::string path;
  SceneFilter filter;
  std::string frame = "as-is";
  Similarity registration;  ///< of --scale, --rotate, --translate, --mirror; turns after `frame`

  /// Declares the options, with the scene as positional argument SCENE, which may be optional, or as option
  /// --scene.
  enum class As { kPositional, kOptionalPositional, kOption };
  void declare(CLI::App& app, As as);

  /// From the captured frame to the world: mirrors, turns the axis named by `frame` up, then registers.
  Similarity world_from_scene() const;

  /// Of the file, or of the scene that load_or_make() makes.
  std::string name() const;

  /// One sentence: what is assumed about the captured frame.
  std::string frame_note() const;
};

/// What SceneOptions::frame may be.
std::vector<std::string> frame_names();

/// What a scene file and its options come to.
struct LoadedScene {
  GaussianScene scene;
  FilterReport filtered;
  EllipsoidScene kept;
};
/// Loads and filters; warns on stderr if nothing is left. \throws Error.
LoadedScene load(const SceneOptions& options, const Progress& progress);
/// The same; without a path, of the scene that needs no file.
LoadedScene load_or_make(const SceneOptions& options, const Progress& progress);

/// The index of a scene; tells on stderr what became of the index file beside it. \throws Error.
SceneIndex open_index(const SceneOptions& options, IndexFiles files, const Progress& progress);

/// The tool and how its contacts are found.
struct QueryOptions {
  Tool tool;
  std::string pipeline = "exact";
  bool no_index_file = false;
  std::optional<double> search_radius;
  int iterations = PaperPipeline::kDefaultIterations;

  void declare_tool(CLI::App& app);
  void declare_pipeline(CLI::App& app);

  /// \throws Error.
  std::unique_ptr<ContactQuery> build(const SceneOptions& scene, const Progress& progress) const;
};

/// A simulated hand: kg, N s/m and N/m. \throws BadValue if one is below zero.
HandProperties parse_hand(const double* mbk);

/// How contacts become a force.
struct ForceOptions {
  std::string model;  ///< empty: see model_for()
  DensityParameters density;
  ProxyParameters proxy;  ///< its stiffness is that of FieldForce, too
  std::string materials;  ///< file of read_materials(); empty: none

  void declare(CLI::App& app);             ///< all of them
  void declare_parameters(CLI::App& app);  ///< all but --model and --materials

  /// What a scene is made of: `materials`, and what its own file says, if `scene` names one. \throws Error
  /// for broken materials.
  using Materials = std::shared_ptr<const MaterialMap>;
  Materials made_of(const std::string& scene, const Progress& progress) const;

  /// The model that was asked for; else the proxy, or the paper's on the contacts of the paper's pipeline.
  std::string model_for(const ContactQuery& query) const;
  /// `query`, whose contacts it is for, must outlive it. `scene` is the file that it is of, and may say what
  /// that is made of; empty: there is no file. \throws Error if the model needs a SceneIndex and has none, or
  /// for broken materials.
  std::unique_ptr<ForceModel> build(const ContactQuery& query, const Tool& tool,
                                    const std::string& scene = {}, const Progress& progress = {}) const;
  /// One of kModels on an index, which must outlive it, as `lookahead` must. Only the proxy feels `made_of`.
  std::unique_ptr<ForceModel> build(const std::string& name, const SceneIndex& index, const Tool& tool,
                                    Materials made_of, Lookahead* lookahead = nullptr) const;
};

}  // namespace palpate::cli
