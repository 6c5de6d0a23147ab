// palpate evaluate: force models against surfaces that are known exactly.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/haptics/evaluation.h>

#include "command.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct Options {
  CommonOptions common;
  QueryOptions query;
  ForceOptions force;
  std::vector<std::string> shapes{"sphere", "plane", "box", "cylinder", "torus", "step", "shell"};
  std::vector<std::string> models{"proxy", "field", "density"};
  std::vector<double> spacings{0.006, 0.003};
  double noise = 0.0015;
  double tilt_degrees = 10.0;
  int scenes = 2;
  int places = 40;
  std::uint64_t seed = 1;
  std::string csv;
};

/// One line of the table.
struct Row {
  std::string shape, model;
  double spacing;
  Evaluation figures;
};

/// A figure of a row: its name in CSV and JSON, its heading, how it is printed, and what it is.
struct Column {
  const char* name;
  const char* heading;
  const char* format;
  double (*value)(const Evaluation&);
};

constexpr double kToMm = 1e3;

const std::vector<Column>& columns() {
  using E = Evaluation;
  static const std::vector<Column> all{
      {"direction_p50_deg", "dir p50", "{:.1f}", [](const E& e) { return e.direction.p50; }},
      {"direction_p95_deg", "p95", "{:.1f}", [](const E& e) { return e.direction.p95; }},
      {"direction_p99_deg", "p99", "{:.1f}", [](const E& e) { return e.direction.p99; }},
      {"magnitude_p05", "F/kd p5", "{:.2f}", [](const E& e) { return e.magnitude.p05; }},
      {"magnitude_p50", "p50", "{:.2f}", [](const E& e) { return e.magnitude.p50; }},
      {"magnitude_p95", "p95", "{:.2f}", [](const E& e) { return e.magnitude.p95; }},
      {"onset_p50_mm", "onset mm", "{:.2f}", [](const E& e) { return kToMm * e.onset.p50; }},
      {"ripple_p50", "ripple p50", "{:.3f}", [](const E& e) { return e.ripple.p50; }},
      {"ripple_p95", "p95", "{:.3f}", [](const E& e) { return e.ripple.p95; }},
      {"jump_max_n", "jump N", "{:.3f}", [](const E& e) { return e.jump.max; }},
      {"loop_p50", "loop p50", "{:.1e}", [](const E& e) { return e.loop.p50; }},
      {"loop_max", "max", "{:.1e}", [](const E& e) { return e.loop.max; }},
      {"silent", "silent", "{:.0f}", [](const E& e) { return static_cast<double>(e.silent); }},
      {"flipped", "flipped", "{:.0f}", [](const E& e) { return static_cast<double>(e.flipped); }},
      {"pushes", "pushes", "{:.0f}", [](const E& e) { return static_cast<double>(e.pushes); }},
      {"through", "through", "{:.0f}", [](const E& e) { return static_cast<double>(e.through); }},
      {"tick_p50_us", "tick us p50", "{:.1f}", [](const E& e) { return e.tick.p50; }},
      {"tick_p99_us", "p99", "{:.1f}", [](const E& e) { return e.tick.p99; }}};
  return all;
}

/// The text of a figure, or a dash where there is none.
std::string text_of(const Column& column, const Evaluation& figures) {
  const double value = column.value(figures);
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(column.format), value);
}

/// Of a column of the table, in characters.
std::size_t width_of(const Column& column) {
  constexpr std::size_t kNarrowest = 7;
  return std::max(kNarrowest, std::string_view(column.heading).size());
}

void print_text(const std::vector<Row>& rows) {
  fmt::print("{:<9} {:>7} {:<8}", "shape", "spacing", "model");
  for (const Column& c : columns()) fmt::print(" {:>{}}", c.heading, width_of(c));
  fmt::print("\n");
  for (const Row& row : rows) {
    fmt::print("{:<9} {:>4.1f} mm {:<8}", row.shape, kToMm * row.spacing, row.model);
    for (const Column& c : columns()) fmt::print(" {:>{}}", text_of(c, row.figures), width_of(c));
    fmt::print("\n");
  }
}

Json to_json(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) {
    Json one{{"shape", row.shape}, {"spacing_m", row.spacing}, {"model", row.model}};
    for (const Column& c : columns()) {
      const double value = c.value(row.figures);
      one[c.name] = std::isnan(value) ? Json() : Json(value);
    }
    json.push_back(std::move(one));
  }
  return json;
}

void write_csv(const std::vector<Row>& rows, const std::string& path) {
  std::string text = "shape,spacing_m,model";
  for (const Column& c : columns()) text += fmt::format(",{}", c.name);
  text += '\n';
  for (const Row& row : rows) {
    text += fmt::format("{},{},{}", row.shape, row.spacing, row.model);
    for (const Column& c : columns()) {
      const double value = c.value(row.figures);
      text += std::isnan(value) ? "," : fmt::format(",{}", value);
    }
    text += '\n';
  }
  OutputFile file(path);
  file.write(text);
  file.commit();
}

Row evaluate_one(const Options& options, const std::string& shape, double spacing, const std::string& model) {
  EvaluationSetup setup;
  setup.shape = shape;
  setup.scene.seed = options.seed;
  setup.scene.spacing = spacing;
  setup.scene.noise = options.noise;
  setup.scene.tilt = options.tilt_degrees * std::numbers::pi / 180.0;
  setup.scenes = static_cast<std::size_t>(options.scenes);
  setup.places = static_cast<std::size_t>(options.places);
  setup.seed = options.seed;
  setup.tool = options.query.tool;
  if (model != "density") setup.stiffness = options.force.proxy.stiffness;
  ForceOptions force = options.force;
  force.model = model;
  setup.model = [&force](const SceneIndex& index, const Tool& tool, double friction) {
    ForceOptions of_this = force;
    of_this.proxy.friction = friction;
    return of_this.build(index, tool);
  };
  return {shape, model, spacing, evaluate(setup)};
}

void run(const Options& options) {
  check_output(options.csv, {options.common.config}, "--csv");
  const Progress progress = terminal_progress(options.common.quiet);
  const std::size_t total = options.shapes.size() * options.spacings.size() * options.models.size();
  std::vector<Row> rows;
  for (const std::string& shape : options.shapes) {
    for (const double spacing : options.spacings) {
      for (const std::string& model : options.models) {
        rows.push_back(evaluate_one(options, shape, spacing, model));
        report(progress, "evaluating", static_cast<double>(rows.size()) / static_cast<double>(total));
      }
    }
  }
  if (!options.csv.empty()) write_csv(rows, options.csv);
  if (options.common.json) {
    fmt::print("{}\n", to_json(rows).dump(2));
  } else {
    print_text(rows);
    if (!options.csv.empty()) fmt::print("wrote {}\n", printable(options.csv));
  }
}

}  // namespace

Command declare_evaluate(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("evaluate", "Force models against the analytic truth: a table");
  auto options = std::make_shared<Options>();
  declare_common(*app, options->common, "print the table as JSON");
  const auto known = procedural_shapes();
  app->add_option("--shapes", options->shapes, "surfaces to feel, as make-scene names them")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(known.begin(), known.end())))
      ->capture_default_str();
  app->add_option("--models", options->models, "force models to compare")
      ->delimiter(',')
      ->check(CLI::IsMember({"proxy", "field", "density"}))
      ->capture_default_str();
  app->add_option("--spacings", options->spacings, "mean distances of neighbours, m")
      ->delimiter(',')
      ->check(CLI::Range(1e-4, 0.1))
      ->capture_default_str();
  add_number(*app, "--noise", options->noise, 0.0, 0.1, "m", "sd of the displacement along the normal");
  add_number(*app, "--tilt", options->tilt_degrees, 0.0, 90.0, "deg", "sd of the tilt of a splat's normal");
  app->add_option("--scenes", options->scenes, "made of each, with one seed after the other")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app->add_option("--places", options->places, "where each is touched, in all")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  add_seed(*app, options->seed, "of the first scene, and of the places");
  app->add_option("--csv", options->csv, "the table as CSV")->type_name("T.csv");
  options->query.tool.semi_axes.setConstant(0.02);
  options->query.declare_tool(*app);
  options->force.declare_parameters(*app);
  return {app, [=] { run(*options); }};
}

}  // namespace palpate::cli
