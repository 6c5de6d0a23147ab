#include "evaluate_capture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/factories.h>
#include <palpate/record/trajectory.h>
#include <palpate/report/capture_report.h>
#include <palpate/report/markup.h>
#include <palpate/report/page.h>
#include <palpate/report/result_files.h>
#include <palpate/study/capture_evaluation.h>

#include "made.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

/// A scene with its contact index and its visible surface.
struct Capture {
  LoadedScene loaded;
  SceneIndex index;
  SeenSurface seen;

  Capture(const SceneConfig& options, const Progress& progress)
      : loaded(load(options, progress)),
        index(loaded.scene, options.filter, options.world_from_scene(), progress),
        seen(loaded.scene, options.world_from_scene()) {}
};

ForceModelMaker maker(const ForceConfig& force, const std::string& model) {
  return [force, kind = force_model_kind(model)](const SceneIndex& index, const Tool& tool, double) {
    return make_force_model(kind, force, index, tool);
  };
}

int rings_of(int rays) {
  int rings = 0;
  while (1 + 3 * rings * (rings + 1) < rays) ++rings;
  return rings;
}

class Study {
 public:
  Study(const CaptureOptions& options, const CaptureTask& task)
      : options_(options),
        task_(task),
        progress_(terminal_progress(task.common.quiet)),
        rings_(rings_of(options.rays)),
        capture_(options.live.scene, progress_),
        aims_(capture_aims(capture_.loaded.kept, capture_.seen, task.tool,
                           static_cast<std::size_t>(task.pushes), task.seed, rings_, progress_)) {
    if (aims_.empty())
      throw Error("{}: no place can be both seen and touched; see palpate info", options.live.scene.path);
    if (!options.against.empty()) {
      SceneConfig other = options.live.scene;
      other.path = options.against;
      against_ = std::make_unique<Capture>(other, progress_);
    }
  }

  CaptureRow measure(const std::string& model) {
    CaptureEvaluation evaluation = on(capture_, model);
    CaptureRow row =
        capture_row(model, evaluation, aims_, static_cast<std::size_t>(options_.slides), progress_);
    if (against_) {
      CaptureEvaluation other = on(*against_, model);
      row.likeness = capture_likeness(evaluation, other, aims_);
    }
    return row;
  }

  /// Plots the worst pushes, and writes their trajectories to the --worst folder.
  std::vector<Plot> worst(const CaptureRow& row, const Provenance& made, std::vector<std::string>& written) {
    std::vector<Plot> plots;
    CaptureEvaluation evaluation = on(capture_, row.model);
    for (const std::size_t i : worst_pushes(row.pushes)) {
      std::vector<CaptureTick> ticks;
      evaluation.push(row.pushes[i].aim, &ticks);
      const std::string name = fmt::format("{}-{}", row.model, i);
      plots.push_back(capture_path_plot(name + "-path", row.pushes[i], ticks, capture_.seen, task_.tool));
      plots.push_back(capture_force_plot(name + "-force", ticks, task_.force.proxy.stiffness));
      plots[plots.size() - 2].title += fmt::format(", {}, push {}", row.model, i);
      plots.back().title += fmt::format(", {}, push {}", row.model, i);
      if (options_.worst.empty()) continue;
      written.push_back((std::filesystem::path(options_.worst) / ("push-" + name + ".csv")).string());
      write_trajectory(capture_trajectory(ticks), written.back(), to_toml(made));
    }
    return plots;
  }

 private:
  CaptureEvaluation on(const Capture& capture, const std::string& model) const {
    return {capture.index, capture.seen, task_.tool, maker(task_.force, model), task_.force.proxy.stiffness,
            rings_};
  }

  const CaptureOptions& options_;
  const CaptureTask& task_;
  Progress progress_;
  int rings_;
  Capture capture_;
  std::unique_ptr<Capture> against_;
  std::vector<CaptureAim> aims_;
};

std::string intro(const CaptureOptions& options, const CaptureTask& task) {
  return fmt::format(
      "{}: {} straight pushes at randomly chosen Gaussians, from any side, three tool radii deep and back, "
      "and {} slides of up to 100 mm, half of the tool's thinnest semi-axis deep; seed {}. The visible "
      "surface is where the transmittance along the push falls below one half, for the first of {} rays over "
      "the tool's cross-section; stiffness {:.4g} N/m. Below are the pushes whose force onset is farthest "
      "from it.",
      options.live.scene.path, task.pushes, options.slides, task.seed, options.rays,
      task.force.proxy.stiffness);
}

Provenance provenance_of(const CaptureOptions& options, const CaptureTask& task) {
  using enum ConfigGroup;
  LiveConfig live = options.live;
  live.tool = task.tool;
  live.force = task.force;
  return made_by(task.common, live, {kScene, kTool, kForce});
}

}  // namespace

void CaptureOptions::declare(CLI::App& app) {
  constexpr int kMost = 100'000;
  declare_scene(app, live, SceneArgument::kOption);
  add_text(app, "--against", against, "SCENE",
           "with --scene: another capture of the same object, with the same registration");
  add_text(app, "--worst", worst, "DIR",
           "with --scene: existing folder for trajectories of the worst pushes, for replay");
  add_count(app, "--rays", rays, 1, 10'000,
            "with --scene: rays over the tool's cross-section that locate the visible surface");
  add_count(app, "--slides", slides, 0, kMost,
            "with --scene: number of slides, at the places of the first pushes");
  need(app, {"--against", "--worst", "--rays", "--slides"}, "--scene");
}

void evaluate_capture(const CaptureOptions& options, const CaptureTask& task) {
  if (!(task.force.proxy.stiffness > 0.0))
    throw Error("--stiffness must be positive: forces are compared with it");
  check_results(task.results, {options.live.scene.path, options.against, task.common.config});
  if (!options.worst.empty() && !std::filesystem::is_directory(options.worst))
    throw Error("--worst {}: is not a folder; make it first", options.worst);
  ResultFiles files(task.results);
  Study study(options, task);
  std::vector<CaptureRow> rows;
  std::vector<Plot> plots;
  const Provenance made = provenance_of(options, task);
  for (const std::string& model : task.models) {
    rows.push_back(study.measure(model));
    for (Plot& plot : study.worst(rows.back(), made, files.written)) plots.push_back(std::move(plot));
  }
  files.write_csv(head_of(made) + capture_csv(rows));
  files.write_html(page_document("Force onset against the visible surface", intro(options, task), plots,
                                 capture_html(rows), to_toml(made)));
  files.write_figures(plots, "evaluate");
  if (task.common.json) {
    print_json(with_made(made, capture_json(rows)));
    return;
  }
  fmt::print("{}", capture_text(rows));
  print_written(files.written);
}

}  // namespace palpate::cli
