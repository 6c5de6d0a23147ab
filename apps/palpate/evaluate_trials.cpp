#include "evaluate_trials.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/factories.h>
#include <palpate/report/figure_column.h>
#include <palpate/report/result_files.h>
#include <palpate/study/trial_tools.h>
#include <palpate/study/trials.h>

#include "made.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

constexpr double kToMm = 1e3, kPercent = 100.0;
constexpr const char* kEven = "even";  // a scene without defects

struct Row {
  std::string tool, place, like;
  TrialSetup setup;
  TrialFigures figures;
};

using Column = FigureColumn<TrialFigures>;

double number(std::size_t n) { return static_cast<double>(n); }

/// NaN of none.
double first_of(const std::vector<std::size_t>& strokes) {
  return strokes.empty() ? std::numeric_limits<double>::quiet_NaN() : number(strokes.front());
}

using Figures = TrialFigures;
constexpr const char *kMm = "{:.2f}", *kShare = "{:.0f}", *kCount = "{:.0f}", *kUs = "{:.0f}";

const std::vector<Column>& columns() {
  static const std::vector<Column> all{
      {"strokes", "strokes", kCount, [](const Figures& f) { return number(f.strokes); }},
      {"slow", nullptr, kCount, [](const Figures& f) { return number(f.slow); }},
      {"silent", "silent", kCount, [](const Figures& f) { return number(f.silent); }},
      {"sunk", "sunk", kCount, [](const Figures& f) { return number(f.sunk); }},
      {"through", "through", kCount, [](const Figures& f) { return number(f.through); }},
      {"stuck", "stuck", kCount, [](const Figures& f) { return number(f.stuck); }},
      {"onsets", "onsets", kCount, [](const Figures& f) { return number(f.onsets); }},
      {"onset_p05_mm", "begin p5", kMm, [](const Figures& f) { return kToMm * f.onset.p05; }},
      {"onset_p50_mm", "p50", kMm, [](const Figures& f) { return kToMm * f.onset.p50; }},
      {"onset_p95_mm", "p95", kMm, [](const Figures& f) { return kToMm * f.onset.p95; }},
      {"true_p50_mm", nullptr, kMm, [](const Figures& f) { return kToMm * f.onset_depth.p50; }},
      {"true_p95_mm", "true p95", kMm, [](const Figures& f) { return kToMm * f.onset_depth.p95; }},
      {"late_p05_mm", "late p5", kMm, [](const Figures& f) { return kToMm * f.late.p05; }},
      {"late_p50_mm", "p50", kMm, [](const Figures& f) { return kToMm * f.late.p50; }},
      {"late_p95_mm", "p95", kMm, [](const Figures& f) { return kToMm * f.late.p95; }},
      {"within_half_mm_percent", "in .5mm", kShare,
       [](const Figures& f) { return kPercent * f.within_half_mm; }},
      {"within_1mm_percent", "in 1mm", kShare, [](const Figures& f) { return kPercent * f.within_1mm; }},
      {"magnitude_p05", "F/kd p5", kMm, [](const Figures& f) { return f.magnitude.p05; }},
      {"magnitude_p50", "p50", kMm, [](const Figures& f) { return f.magnitude.p50; }},
      {"magnitude_p95", "p95", kMm, [](const Figures& f) { return f.magnitude.p95; }},
      {"step_max_n", "step N", kMm, [](const Figures& f) { return f.step.max; }},
      {"tick_p50_us", "tick us", kUs, [](const Figures& f) { return f.tick.p50; }},
      {"tick_p99.9_us", "p99.9", kUs, [](const Figures& f) { return f.tick.p999; }},
      {"tick_max_us", "max", kUs, [](const Figures& f) { return f.tick.max; }},
      {"first_silent", "1st silent", kCount, [](const Figures& f) { return first_of(f.silent_strokes); }},
      {"first_sunk", "sunk", kCount, [](const Figures& f) { return first_of(f.sunk_strokes); }},
      {"first_through", "through", kCount, [](const Figures& f) { return first_of(f.through_strokes); }},
      {"first_stuck", "stuck", kCount, [](const Figures& f) { return first_of(f.stuck_strokes); }},
      {"first_late", "late", kCount, [](const Figures& f) { return first_of(f.late_strokes); }},
  };
  return all;
}

std::size_t width_of(const Column& column) {
  constexpr std::size_t kLeast = 6;
  return std::max(kLeast, std::string_view(column.heading).size());
}

void print_table(const std::vector<Row>& rows) {
  fmt::print(
      "Strokes in which nothing is felt deep inside, the proxy sinks in, or comes out behind, and at whose\n"
      "end a force is left; where the force begins, from the seen and the true surface, and late, from the\n"
      "seen one or the first ellipsoid, mm; shares of that, %; |F| over stiffness times depth; largest step\n"
      "of the force; time of a tick; the first strokes that failed, for --stroke.\n\n");
  fmt::print("{:<12} {:<7} {:<9}", "tool", "place", "like");
  for (const Column& c : columns()) {
    if (c.heading != nullptr) fmt::print(" {:>{}}", c.heading, width_of(c));
  }
  fmt::print("\n");
  for (const Row& row : rows) {
    fmt::print("{:<12} {:<7} {:<9}", row.tool, row.place, row.like);
    for (const Column& c : columns()) {
      if (c.heading != nullptr) fmt::print(" {:>{}}", text_of(c, row.figures), width_of(c));
    }
    fmt::print("\n");
  }
}

Json to_json(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) {
    Json one{{"tool", row.tool}, {"place", row.place}, {"like", row.like}};
    put_figures(columns(), row.figures, one);
    one["silent_strokes"] = row.figures.silent_strokes;
    one["sunk_strokes"] = row.figures.sunk_strokes;
    one["through_strokes"] = row.figures.through_strokes;
    one["stuck_strokes"] = row.figures.stuck_strokes;
    one["late_strokes"] = row.figures.late_strokes;
    json.push_back(std::move(one));
  }
  return json;
}

std::string to_csv(const std::vector<Row>& rows) {
  std::string text = "tool,place,like" + csv_names(columns()) + "\n";
  for (const Row& row : rows)
    text += fmt::format("{},{},{}{}\n", row.tool, row.place, row.like, csv_figures(columns(), row.figures));
  return text;
}

std::string ticks_csv(const std::vector<TrialTick>& ticks) {
  std::string text = "t,x,y,z,proxy_x,proxy_y,proxy_z,fx,fy,fz,depth_m,proxy_depth_m,confidence\n";
  constexpr double kPeriod = 1e-3;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    text += fmt::format("{:.3f}", kPeriod * number(i));
    for (const Eigen::Vector3d* v : {&ticks[i].tool, &ticks[i].proxy, &ticks[i].force})
      text += fmt::format(",{:.7g},{:.7g},{:.7g}", v->x(), v->y(), v->z());
    text += fmt::format(",{:.6g},{:.6g},{:.4g}\n", ticks[i].depth, ticks[i].proxy_depth, ticks[i].confidence);
  }
  return text;
}

std::string in_mm(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f} mm", kToMm * *value) : "-";
}

/// Each tool that is tried is named among the settings.
Provenance provenance_of(const TrialTask& task) {
  LiveConfig live;
  live.force = task.force;
  return made_by(task.common, SceneOrigin(), live, {ConfigGroup::kForce});
}

void repeat(const Row& row, const TrialOptions& options, const TrialTask& task, ResultFile& csv) {
  std::vector<TrialTick> ticks;
  const TrialStroke stroke = repeat_trial(row.setup, static_cast<std::size_t>(options.stroke), &ticks);
  std::vector<std::string> written;
  const Provenance made = provenance_of(task);
  csv.write(head_of(made) + ticks_csv(ticks), written);
  if (task.common.json) {
    const auto value = [](const std::optional<double>& v) { return v ? Json(*v) : Json(); };
    print_json(Json{{"made", made_json(made)},
                    {"tool", row.tool},
                    {"place", row.place},
                    {"like", row.like},
                    {"stroke", stroke.number},
                    {"speed", stroke.speed},
                    {"seen", value(stroke.seen)},
                    {"touched", value(stroke.touched)},
                    {"felt", value(stroke.felt)},
                    {"late", value(stroke.late())},
                    {"silent", stroke.silent},
                    {"sunk", stroke.sunk},
                    {"through", stroke.through},
                    {"stuck", stroke.stuck},
                    {"step", stroke.step}});
    return;
  }
  fmt::print(
      "{}, {}, {}, stroke {} at {:.3g} m/s: seen {}, touched {}, felt {} on the way, late {}{}{}{}{}\n",
      row.tool, row.place, row.like, stroke.number, stroke.speed, in_mm(stroke.seen), in_mm(stroke.touched),
      in_mm(stroke.felt), in_mm(stroke.late()), stroke.silent ? "; silent" : "", stroke.sunk ? "; sunk" : "",
      stroke.through ? "; through" : "", stroke.stuck ? "; stuck" : "");
  for (const std::string& path : written) fmt::print("wrote {}\n", printable(path));
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

TrialSetup setup_of(const Tool& tool, const Row& row, int strokes, const TrialTask& task) {
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

std::vector<Row> rows_of(const TrialOptions& options, const TrialTask& task) {
  std::vector<Row> rows;
  for (const std::string& name : options.tools) {
    const Tool tool = tool_of(name);
    for (const std::string& place : options.places) {
      for (const std::string& like : options.like) {
        Row row{std::filesystem::path(name).stem().string(), place, like, {}, {}};
        row.setup = setup_of(tool, row, options.strokes, task);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

void measure(std::vector<Row>& rows, const Progress& progress) {
  std::mutex mutex;
  std::vector<double> done(rows.size(), 0.0);
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
    rows[i].figures = run_trials(rows[i].setup, [&](std::string_view stage, double fraction) {
      const std::lock_guard lock(mutex);
      done[i] = fraction;
      double sum = 0.0;
      for (const double one : done) sum += one;
      report(progress, stage, sum / number(rows.size()));
    });
  });
}

}  // namespace

TrialOptions::TrialOptions()
    : tools(trial_tools().begin(), trial_tools().end()),
      places(trial_places().begin(), trial_places().end()),
      like{kEven} {}

void TrialOptions::declare(CLI::App& app) {
  constexpr int kMost = 1'000'000;
  add_count(app, "--trials", strokes, 1, kMost,
            "instead: push the proxy of any tool at any place, at 0.05 to 50 m/s, so often a row");
  add_texts(app, "--trial-tools", tools, "NAME,...",
            fmt::format("of --trials: {}, or FILE.toml", fmt::join(trial_tools(), ", ")));
  add_choices(app, "--trial-places", places, {trial_places().begin(), trial_places().end()},
              "of --trials: where the tool is pushed at");
  std::vector<std::string> kinds{kEven};
  kinds.insert(kinds.end(), capture_defects().begin(), capture_defects().end());
  add_choices(app, "--like", like, kinds, "of --trials: what captures are like, as make-scene makes them");
  add_count(app, "--stroke", stroke, 0, kMost,
            "of --trials in one row: this one alone, and every tick of it in --csv");
}

void evaluate_trials(const TrialOptions& options, const TrialTask& task) {
  if (!(task.force.proxy.stiffness > 0.0)) throw Error("--stiffness 0: forces are held against it");
  check_output(task.csv, {task.common.config}, "--csv");
  std::vector<Row> rows = rows_of(options, task);
  ResultFile csv(task.csv);
  if (options.stroke >= 0) {
    if (rows.size() != 1) throw Error("--stroke: of one of --trial-tools, --trial-places and --like each");
    repeat(rows.front(), options, task, csv);
    return;
  }
  measure(rows, terminal_progress(task.common.quiet));
  std::vector<std::string> written;
  const Provenance made = provenance_of(task);
  csv.write(head_of(made) + to_csv(rows), written);
  if (task.common.json) {
    print_json(with_made(made, to_json(rows)));
    return;
  }
  print_table(rows);
  for (const std::string& path : written) fmt::print("wrote {}\n", printable(path));
}

}  // namespace palpate::cli
