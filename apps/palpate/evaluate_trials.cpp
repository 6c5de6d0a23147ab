#include "evaluate_trials.h"

#include <cstdio>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/factories.h>
#include <palpate/report/result_files.h>
#include <palpate/report/trial_table.h>
#include <palpate/study/trial_tools.h>
#include <palpate/study/trials.h>

#include "made.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

constexpr const char* kEven = "even";  // a scene without defects

/// Provenance without the tool: the tools are among the settings.
Provenance provenance_of(const TrialTask& task) {
  LiveConfig live;
  live.force = task.force;
  return made_by(task.common, SceneOrigin(), live, {ConfigGroup::kForce});
}

void repeat(const TrialRow& row, const TrialOptions& options, const TrialTask& task, ResultFiles& files) {
  std::vector<TrialTick> ticks;
  const TrialStroke stroke = repeat_trial(row.setup, static_cast<std::size_t>(options.stroke), &ticks);
  const Provenance made = provenance_of(task);
  files.write_csv(head_of(made) + trial_ticks_csv(ticks));
  if (task.common.json) {
    Json json{{"made", made_json(made)}};
    json.update(trial_stroke_json(row, stroke));
    print_json(json);
    return;
  }
  fmt::print("{}", trial_stroke_text(row, stroke));
  print_written(files.written);
}

Tool tool_of(const std::string& name) {
  if (name.ends_with(".toml")) return read_tool(name);
  const auto tool = trial_tool(name);
  if (!tool) {
    throw Error("--trial-tools: there is no '{}'; use a FILE.toml or one of: {}", name,
                fmt::join(trial_tools(), ", "));
  }
  return *tool;
}

TrialSetup setup_of(const Tool& tool, const TrialRow& row, int strokes, const TrialTask& task) {
  TrialSetup setup;
  setup.place = row.place;
  setup.tool = tool;
  setup.tip_first = row.tool == "needle";
  if (row.like != kEven) set_defect(setup.defects, row.like);
  setup.stiffness = task.force.proxy.stiffness;
  setup.strokes = static_cast<std::size_t>(strokes);
  setup.seed = task.seed;
  setup.model = [force = task.force](const SceneIndex& index, const Tool& held, double) {
    return make_force_model(ForceModelKind::kProxy, force, index, held);
  };
  return setup;
}

std::vector<TrialRow> rows_of(const TrialOptions& options, const TrialTask& task) {
  std::vector<TrialRow> rows;
  for (const std::string& name : options.tools) {
    const Tool tool = tool_of(name);
    for (const std::string& place : options.places) {
      for (const std::string& like : options.like) {
        TrialRow row{std::filesystem::path(name).stem().string(), place, like, {}, {}};
        row.setup = setup_of(tool, row, options.strokes, task);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

}  // namespace

TrialOptions::TrialOptions()
    : tools(trial_tools().begin(), trial_tools().end()),
      places(trial_places().begin(), trial_places().end()),
      like{kEven} {}

void TrialOptions::declare(CLI::App& app) {
  constexpr int kMost = 1'000'000;
  add_count(app, "--trials", strokes, 1, kMost,
            "run trials of the proxy model instead: strokes per row of tool, place and capture kind, at 0.05 "
            "to 50 m/s");
  add_texts(app, "--trial-tools", tools, "NAME,...",
            fmt::format("with --trials: tools to push: {}, or FILE.toml", fmt::join(trial_tools(), ", ")));
  add_choices(app, "--trial-places", places, {trial_places().begin(), trial_places().end()},
              "with --trials: places to push at");
  std::vector<std::string> kinds{kEven};
  kinds.insert(kinds.end(), capture_defects().begin(), capture_defects().end());
  add_choices(app, "--like", like, kinds,
              "with --trials: defects of the captures, named as in make-scene; even = none");
  add_count(app, "--stroke", stroke, 0, kMost,
            "with --trials of one row: run only the stroke with this number, and write its ticks to --csv");
  need(app, {"--trial-tools", "--trial-places", "--like", "--stroke"}, "--trials");
}

void evaluate_trials(const TrialOptions& options, const TrialTask& task) {
  if (!(task.force.proxy.stiffness > 0.0))
    throw Error("--stiffness must be positive: forces are compared with it");
  check_output(task.csv, {task.common.config}, "--csv");
  check_output(task.csv, options.tools, "--csv");
  std::vector<TrialRow> rows = rows_of(options, task);
  ResultFiles files({task.csv, {}, {}});
  if (options.stroke >= 0) {
    if (rows.size() != 1)
      throw Error("--stroke requires exactly one of --trial-tools, --trial-places and --like");
    repeat(rows.front(), options, task, files);
    return;
  }
  measure_trials(rows, terminal_progress(task.common.quiet));
  const Provenance made = provenance_of(task);
  files.write_csv(head_of(made) + trial_csv(rows));
  if (task.common.json) {
    print_json(with_made(made, trial_json(rows)));
    return;
  }
  fmt::print("{}", trial_text(rows));
  print_written(files.written);
}

}  // namespace palpate::cli
