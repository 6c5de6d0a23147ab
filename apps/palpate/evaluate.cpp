// palpate evaluate: force models compared with analytic surfaces, or on a capture with its visible surface.
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/factories.h>
#include <palpate/report/evaluation_page.h>
#include <palpate/report/evaluation_table.h>
#include <palpate/report/result_files.h>

#include "command.h"
#include "evaluate_capture.h"
#include "evaluate_trials.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct EvaluateOptions {
  CommonOptions common;
  LiveConfig live;  ///< tool and force
  std::vector<std::string> shapes{"sphere", "plane", "box", "cylinder", "torus", "step", "shell"};
  std::vector<std::string> models{kForceModelNames.begin(), kForceModelNames.end()};
  std::vector<double> spacings{0.006, 0.003};
  double noise = 0.0015;
  double tilt_degrees = 10.0;
  int scenes = 2;
  int places = 40;
  int pushes = 100;
  std::uint64_t seed = 1;
  ResultNames results;
  CaptureOptions capture;
  TrialOptions trials;
};

EvaluationSetup setup_of(const EvaluateOptions& options, const std::string& shape, double spacing,
                         const std::string& model) {
  EvaluationSetup setup;
  setup.shape = shape;
  setup.scene.seed = options.seed;
  setup.scene.spacing = spacing;
  setup.scene.noise = options.noise;
  setup.scene.tilt = options.tilt_degrees * std::numbers::pi / 180.0;
  setup.scenes = static_cast<std::size_t>(options.scenes);
  setup.places = static_cast<std::size_t>(options.places);
  setup.pushes = static_cast<std::size_t>(options.pushes);
  setup.seed = options.seed;
  setup.tool = options.live.tool;
  if (model != "density") setup.stiffness = options.live.force.proxy.stiffness;
  if (model == "proxy") setup.friction = options.live.force.proxy.friction;
  setup.model = [force = options.live.force, kind = force_model_kind(model)](
                    const SceneIndex& index, const Tool& tool, double friction) {
    ForceConfig rubbing = force;
    rubbing.proxy.friction = friction;
    return make_force_model(kind, rubbing, index, tool);
  };
  return setup;
}

std::vector<EvaluationRow> measure_all(const EvaluateOptions& options) {
  const Progress progress = terminal_progress(options.common.quiet);
  const auto total =
      static_cast<double>(options.shapes.size() * options.spacings.size() * options.models.size());
  std::vector<EvaluationRow> rows;
  const Progress of_row = [&](std::string_view stage, double fraction) {
    report(progress, stage, (static_cast<double>(rows.size()) + 0.999 * fraction) / total);
  };
  for (const std::string& shape : options.shapes) {
    for (const double spacing : options.spacings) {
      for (const std::string& model : options.models)
        rows.push_back(evaluation_row(setup_of(options, shape, spacing, model), model, of_row));
    }
  }
  report(progress, "evaluating", 1.0);
  compare_densities(rows, options.spacings.front());
  return rows;
}

std::string setup_text(const EvaluateOptions& options) {
  return fmt::format(
      "A tool of {} touches surfaces of known shape, made of Gaussians that are displaced by {:.3g} mm and "
      "tilted by {:.3g} degrees (standard deviations). {} scenes per row, seeds from {}; {} places and {} "
      "pushes per row; stiffness {:.4g} N/m.",
      tool_in_words(options.live.tool), 1e3 * options.noise, options.tilt_degrees, options.scenes,
      options.seed, options.places, options.pushes, options.live.force.proxy.stiffness);
}

void run(const EvaluateOptions& options) {
  if (!options.capture.live.scene.path.empty()) {
    evaluate_capture(options.capture, {options.common, options.live.tool, options.live.force, options.models,
                                       options.pushes, options.seed, options.results});
    return;
  }
  if (options.trials.strokes > 0) {
    evaluate_trials(options.trials, {options.common, options.live.force, options.seed, options.results.csv});
    return;
  }
  check_results(options.results, {options.common.config});
  ResultFiles files(options.results);
  const std::vector<EvaluationRow> rows = measure_all(options);
  const std::vector<Plot> figures = evaluation_figures(rows, options.live.force.proxy.stiffness);
  const Provenance made =
      made_by(options.common, SceneOrigin(), options.live, {ConfigGroup::kTool, ConfigGroup::kForce});
  files.write_csv(head_of(made) + evaluation_csv(rows));
  files.write_html(evaluation_page(rows, figures, setup_text(options), to_toml(made)));
  files.write_figures(figures, "evaluate");
  if (options.common.json) {
    print_json(with_made(made, evaluation_json(rows)));
    return;
  }
  fmt::print("{}", evaluation_text(rows));
  print_written(files.written);
}

void declare_what(CLI::App& app, EvaluateOptions& options) {
  const auto known = procedural_shapes();
  add_choices(app, "--shapes", options.shapes, {known.begin(), known.end()},
              "surfaces to evaluate, named as in make-scene");
  add_choices(app, "--models", options.models, {kForceModelNames.begin(), kForceModelNames.end()},
              "force models to compare");
  add_numbers(app, "--spacings", options.spacings, 1e-4, 0.1,
              "mean distances between neighbouring Gaussians, m");
  add_number(app, "--noise", options.noise, 0.0, 0.1, "m",
             "standard deviation of the displacement along the normal");
  add_number(app, "--tilt", options.tilt_degrees, 0.0, 90.0, "deg",
             "standard deviation of the tilt of a splat's normal");
}

void declare_how_much(CLI::App& app, EvaluateOptions& options) {
  constexpr int kMost = 100'000;
  add_count(app, "--scenes", options.scenes, 1, 1000, "scenes per row, with consecutive seeds");
  add_count(app, "--places", options.places, 1, kMost,
            "places per row to press and slide along, over all scenes");
  add_count(app, "--pushes", options.pushes, 0, kMost,
            "pushes per row through the surface, every tenth at 2 m/s; with --scene: pushes in and back");
  add_seed(app, options.seed, "random seed of the first scene and of the places");
}

/// Refuses options that the other kinds of evaluation would ignore.
void declare_what_excludes(CLI::App& app) {
  const std::vector<std::string> surfaces{"--shapes", "--spacings", "--noise",
                                          "--tilt",   "--scenes",   "--places"};
  exclude(app, surfaces, "--scene");
  exclude(app, surfaces, "--trials");
  exclude(app,
          {"--scene", "--models", "--pushes", "--html", "--svg", "--tool", "--k-base", "--damping", "--f-max",
           "--tau-direction", "--tau-opacity", "--tau-velocity"},
          "--trials");
}

}  // namespace

Command declare_evaluate(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "evaluate",
                  "Force models against analytic ground truth, or against the visible surface of a capture");
  auto options = std::make_shared<EvaluateOptions>();
  declare_common(app, options->common, "print the tables as JSON");
  declare_what(app, *options);
  declare_how_much(app, *options);
  declare_results(app, options->results, "all figures as CSV, one line per row");
  options->capture.declare(app);
  options->trials.declare(app);
  options->live.tool = Tool(Eigen::Vector3d::Constant(0.02));
  declare_field(app, options->live, "tool");
  options->live.force.proxy.friction = 0.3;  // measured in separate slides and rests
  declare_force_parameters(app, options->live);
  declare_what_excludes(app);
  return {&app, [=, &app] {
            // Captures and trials use the default model, without friction.
            const bool rubs = options->capture.live.scene.path.empty() && options->trials.strokes == 0;
            if (!rubs && !is_given(app, "--friction")) options->live.force.proxy.friction = 0.0;
            run(*options);
          }};
}

}  // namespace palpate::cli
