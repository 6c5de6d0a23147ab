// palpate make-scene: a synthetic scene with an analytically known surface.
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/scene/ply_writer.h>
#include <palpate/study/capture_defects.h>
#include <palpate/study/procedural.h>
#include <palpate/study/still_life.h>

#include "command.h"
#include "options.h"
#include "output.h"

namespace palpate::cli {
namespace {

struct MakeSceneOptions {
  CommonOptions common;
  std::string shape;
  std::string out;
  ProceduralOptions procedural;
  double tilt_degrees = 0.0;
  std::vector<std::string> like;  ///< names from capture_defects()
};

/// Writes the still life, which has its own lighting, materials and spacing per object, and no capture
/// defects.
void run_still_life(const MakeSceneOptions& options) {
  if (options.procedural.noise > 0.0 || options.tilt_degrees > 0.0 || !options.like.empty())
    throw Error("{} takes neither --noise nor --tilt nor --like; leave them out, or make a table",
                kStillLife);
  const double spacing = options.procedural.spacing.value_or(kStillLifeSpacing);
  const StillLife made = make_still_life(options.procedural.seed, spacing);
  write_ply(
      made.scene, options.out,
      fmt::format("palpate make-scene {} seed {} spacing {} m", kStillLife, options.procedural.seed, spacing),
      material_columns(made));
  if (!options.common.quiet)
    fmt::print("wrote {}: {}, {} Gaussians\n", printable(options.out), kStillLife, made.scene.size());
}

void run(const MakeSceneOptions& options) {
  check_output(options.out, {options.common.config});
  if (options.shape == kStillLife) {
    run_still_life(options);
    return;
  }
  ProceduralOptions procedural = options.procedural;
  procedural.tilt = options.tilt_degrees * std::numbers::pi / 180.0;
  const auto surface = make_surface(options.shape);
  CaptureDefects defects;
  for (const std::string& name : options.like) set_defect(defects, name);
  const GaussianScene scene = make_capture(*surface, procedural, defects);
  const double spacing = procedural.spacing.value_or(surface->default_spacing());
  const std::string like = options.like.empty() ? "" : fmt::format(" like {}", fmt::join(options.like, ","));
  write_ply(scene, options.out,
            fmt::format("palpate make-scene {} seed {} spacing {} m noise {} m tilt {} deg{}", options.shape,
                        procedural.seed, spacing, procedural.noise, options.tilt_degrees, like));
  if (!options.common.quiet)
    fmt::print("wrote {}: {}, {} Gaussians\n", printable(options.out), options.shape, scene.size());
}

}  // namespace

Command declare_make_scene(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "make-scene", "Synthetic scene with analytically known surface, as INRIA .ply");
  auto options = std::make_shared<MakeSceneOptions>();
  declare_common(app, options->common);
  const auto shapes = procedural_shapes();
  std::vector<std::string> names{shapes.begin(), shapes.end()};
  names.emplace_back(kStillLife);
  add_choice(app, "SHAPE", options->shape, names, "shape of the surface").required();
  add_text(app, "--out", options->out, "S.ply", "output file of the scene").required();
  add_seed(app, options->procedural.seed, "random seed");
  add_parsed(app, "--spacing", "m",
             "mean distance between neighbouring Gaussians, m (default: depends on the shape)",
             [options](const std::string& text) { options->procedural.spacing = parse_positive(text); });
  add_number(app, "--noise", options->procedural.noise, 0.0, 1.0, "m",
             "standard deviation of the displacement along the normal");
  add_number(app, "--tilt", options->tilt_degrees, 0.0, 90.0, "deg",
             "standard deviation of the tilt of a splat's normal");
  add_choices(app, "--like", options->like, {capture_defects().begin(), capture_defects().end()},
              "defects of real captures to add");
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
