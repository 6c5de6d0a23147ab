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
#include <palpate/study/capture_evaluation.h>

#include "figure_column.h"
#include "markup.h"
#include "output.h"
#include "page.h"
#include "result_files.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

constexpr double kToMm = 1e3, kPercent = 100.0;
constexpr std::size_t kWorst = 5;

/// A scene that can be seen and felt.
struct Capture {
  LoadedScene loaded;
  SceneIndex index;
  SeenSurface seen;

  Capture(const SceneConfig& options, const Progress& progress)
      : loaded(load(options, progress)),
        index(loaded.scene, options.filter, options.world_from_scene(), progress),
        seen(loaded.scene, options.world_from_scene()) {}
};

/// What a model was found to do.
struct Row {
  std::string model;
  CaptureFigures figures;
  std::optional<CaptureLikeness> likeness;
  std::vector<CapturePush> pushes;
};

using Column = FigureColumn<Row>;

double of_likeness(const Row& row, double (*value)(const CaptureLikeness&)) {
  return row.likeness ? value(*row.likeness) : std::numeric_limits<double>::quiet_NaN();
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{
      {"pushes", "pushes", "{:.0f}", [](const Row& r) { return static_cast<double>(r.figures.pushes); }},
      {"onset_within_5mm_percent", "force begins within 5 mm of the seen surface, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.onset_within; }},
      {"late_percent", "more than 5 mm behind it, or never, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.late; }},
      {"early_percent", "more than 5 mm before it, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.early; }},
      {"onset_p50_mm", "depth at which it begins, median, mm", "{:.2f}",
       [](const Row& r) { return kToMm * r.figures.onset.p50; }},
      {"silent_5mm_percent", "silent 5 mm deep, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.silent_5mm; }},
      {"silent_10mm_percent", "silent 10 mm deep, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.silent_10mm; }},
      {"untouched_percent", "more than 1 N before an ellipsoid is touched, %", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.untouched; }},
      {"push_step_p50_n", "largest step of the force, median push, N", "{:.3f}",
       [](const Row& r) { return r.figures.push_step.p50; }},
      {"push_step_max_n", "worst push, N", "{:.3f}", [](const Row& r) { return r.figures.push_step.max; }},
      {"slides", "slides", "{:.0f}", [](const Row& r) { return static_cast<double>(r.figures.slides); }},
      {"slide_strong_percent", "force above three times stiffness x depth, % of ticks", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.slide_strong; }},
      {"slide_silent_percent", "silent, % of ticks", "{:.1f}",
       [](const Row& r) { return kPercent * r.figures.slide_silent; }},
      {"slide_step_p50_n", "largest step of the force, median slide, N", "{:.3f}",
       [](const Row& r) { return r.figures.slide_step.p50; }},
      {"slide_step_max_n", "worst slide, N", "{:.3f}", [](const Row& r) { return r.figures.slide_step.max; }},
      {"tick_p50_us", "a tick, median, us", "{:.1f}", [](const Row& r) { return r.figures.tick.p50; }},
      {"tick_p99.9_us", "p99.9, us", "{:.1f}", [](const Row& r) { return r.figures.tick.p999; }},
      {"first_touch_within_5mm_percent", "first ellipsoid touched within 5 mm of the seen surface, %",
       "{:.1f}", [](const Row& r) { return kPercent * r.figures.touched_within; }},
      {"against_p10", "force in the other capture over that in this one, p10", "{:.2f}",
       [](const Row& r) { return of_likeness(r, [](const CaptureLikeness& l) { return l.p10; }); }},
      {"against_p90", "p90", "{:.2f}",
       [](const Row& r) { return of_likeness(r, [](const CaptureLikeness& l) { return l.p90; }); }},
      {"silent_in_one_percent", "silent 5 mm deep in one of both alone, %", "{:.1f}",
       [](const Row& r) {
         return of_likeness(r, [](const CaptureLikeness& l) { return kPercent * l.silent_in_one; });
       }},
  };
  return all;
}

bool is_shown(const Column& column, const std::vector<Row>& rows) {
  return std::ranges::any_of(rows, [&](const Row& row) { return !std::isnan(column.value(row)); });
}

void print_table(const std::vector<Row>& rows) {
  fmt::print("{:<66}", "");
  for (const Row& row : rows) fmt::print(" {:>8}", row.model);
  fmt::print("\n");
  for (const Column& column : columns()) {
    if (!is_shown(column, rows)) continue;
    fmt::print("{:<66}", column.heading);
    for (const Row& row : rows) fmt::print(" {:>8}", text_of(column, row));
    fmt::print("\n");
  }
}

Json to_json(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) {
    Json one{{"model", row.model}};
    put_figures(columns(), row, one);
    json.push_back(std::move(one));
  }
  return json;
}

std::string to_csv(const std::vector<Row>& rows) {
  std::string text = "model" + csv_names(columns()) + "\n";
  for (const Row& row : rows) text += row.model + csv_figures(columns(), row) + "\n";
  return text;
}

std::string to_html(const std::vector<Row>& rows) {
  std::string html = "<div class='table' tabindex='0'><table>\n<tr><th></th>";
  for (const Row& row : rows) html += fmt::format("<th>{}</th>", markup_escaped(row.model));
  html += "</tr>\n";
  for (const Column& column : columns()) {
    if (!is_shown(column, rows)) continue;
    html += fmt::format("<tr><td>{}</td>", markup_escaped(column.heading));
    for (const Row& row : rows) html += fmt::format("<td>{}</td>", text_of(column, row));
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

/// How wrong a push is: how far its force begins from the seen surface, or farther than any if it never does.
double error_of(const CapturePush& push) {
  return push.onset ? std::abs(*push.onset) : std::numeric_limits<double>::max();
}

/// Numbers of the worst pushes, the worst first.
std::vector<std::size_t> worst_of(const std::vector<CapturePush>& pushes) {
  std::vector<std::size_t> order(pushes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return error_of(pushes[a]) > error_of(pushes[b]); });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

std::string onset_text(const CapturePush& push) {
  if (!push.onset) return "never";
  return fmt::format("{:.1f} mm {} the seen surface", kToMm * std::abs(*push.onset),
                     *push.onset < 0.0 ? "before" : "behind");
}

/// Seen surface, tool and proxy in the plane of the push that has most of what is aside in it.
Plot path_plot(const std::string& name, const CapturePush& push, const std::vector<CaptureTick>& ticks,
               const SeenSurface& seen, const Tool& tool) {
  const CaptureAim& aim = push.aim;
  const Eigen::Vector3d aside = aim.along.unitOrthogonal();
  const double shown = 3.0 * tool.radius();
  Plot plot{name,
            "Seen surface and paths",
            fmt::format("in a plane through the push; the force begins {}", onset_text(push)),
            {"aside, mm", false, -kToMm * shown, kToMm * shown, {}},
            {"height over where the tool meets the seen surface, mm", false, {}, {}, {}},
            {}};
  const Eigen::Vector3d touch = aim.from + aim.seen * aim.along;
  const auto image = [&](const Eigen::Vector3d& p) {
    return PlotPoint(kToMm * (p - touch).dot(aside), -kToMm * (p - touch).dot(aim.along));
  };
  PlotSeries surface{"seen surface", PlotSeries::Style::kDots, PlotSeries::kTruth, {}};
  const SeenRays rays(seen, aim.from, aim.along, shown);
  constexpr int kPoints = 120;
  for (int k = 0; k <= kPoints; ++k) {
    const Eigen::Vector3d way = shown * (2.0 * k / kPoints - 1.0) * aside;
    const auto depth = rays.depth(aim.from + way);
    if (depth && std::abs(*depth - aim.seen) < 2.0 * shown)
      surface.points.push_back(image(aim.from + way + *depth * aim.along));
  }
  PlotSeries hand{"tool", PlotSeries::Style::kLine, 1, {}}, proxy{"proxy", PlotSeries::Style::kLine, 0, {}};
  for (const CaptureTick& tick : ticks) {
    hand.points.push_back(image(tick.tool));
    proxy.points.push_back(image(tick.proxy));
  }
  PlotSeries outline{"tool where it meets the seen surface", PlotSeries::Style::kLine, 2, {}};
  constexpr int kCorners = 72;
  const Ellipsoid solid = tool.parts().front().at({touch, Eigen::Quaterniond::Identity()});
  for (int k = 0; k <= kCorners; ++k) {
    // The silhouette from across the plane.
    const double angle = 2.0 * std::numbers::pi * k / kCorners;
    const Eigen::Vector3d out = std::cos(angle) * aside + std::sin(angle) * aim.along;
    const Eigen::Vector3d n = solid.axes.transpose() * out;
    outline.points.push_back(image(solid.center + solid.axes * n / n.norm()));
  }
  plot.series = {std::move(surface), std::move(hand), std::move(proxy), std::move(outline)};
  return plot;
}

Plot force_plot(const std::string& name, const std::vector<CaptureTick>& ticks, double stiffness) {
  Plot plot{name,
            "Force",
            "in, and back",
            {"depth below the seen surface, mm", false, {}, {}, {}},
            {"force, N", false, 0.0, {}, {}},
            {}};
  PlotSeries felt{"felt", PlotSeries::Style::kLine, 0, {}},
      spring{"stiffness x depth", PlotSeries::Style::kLine, PlotSeries::kTruth, {}};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    felt.points.emplace_back(kToMm * ticks[i].depth, ticks[i].force.norm());
    if (i < ticks.size() / 2)
      spring.points.emplace_back(kToMm * ticks[i].depth, stiffness * std::max(0.0, ticks[i].depth));
  }
  plot.series = {std::move(felt), std::move(spring)};
  return plot;
}

Trajectory trajectory_of(const std::vector<CaptureTick>& ticks) {
  constexpr double kPeriod = 1e-3;
  Trajectory trajectory;
  for (std::size_t i = 0; i < ticks.size(); ++i)
    trajectory.push_back(
        {kPeriod * static_cast<double>(i), {ticks[i].tool, Eigen::Quaterniond::Identity()}, {}});
  return trajectory;
}

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
    if (aims_.empty()) throw Error("{}: nothing of it can be seen and touched", options.live.scene.path);
    if (!options.against.empty()) {
      SceneConfig other = options.live.scene;
      other.path = options.against;
      against_ = std::make_unique<Capture>(other, progress_);
    }
  }

  Row measure(const std::string& model) {
    Row row{model, {}, {}, {}};
    CaptureEvaluation evaluation = on(capture_, model);
    std::vector<CaptureSlide> slides;
    const auto slide_count = std::min(aims_.size(), static_cast<std::size_t>(options_.slides));
    const auto work = static_cast<double>(aims_.size() + slide_count);
    for (const CaptureAim& aim : aims_) {
      row.pushes.push_back(evaluation.push(aim));
      report(progress_, "pushing, " + model, 0.999 * static_cast<double>(row.pushes.size()) / work);
    }
    for (std::size_t i = 0; i < slide_count; ++i) {
      slides.push_back(evaluation.slide(aims_[i]));
      report(progress_, "sliding, " + model, static_cast<double>(aims_.size() + i + 1) / work);
    }
    row.figures = evaluation.figures(row.pushes, slides);
    if (against_) {
      CaptureEvaluation other = on(*against_, model);
      row.likeness = capture_likeness(evaluation, other, aims_);
    }
    return row;
  }

  /// Pictures of the worst pushes, whose trajectories are written to the folder that was asked for.
  std::vector<Plot> worst(const Row& row, std::vector<std::string>& written) {
    std::vector<Plot> plots;
    CaptureEvaluation evaluation = on(capture_, row.model);
    for (const std::size_t i : worst_of(row.pushes)) {
      std::vector<CaptureTick> ticks;
      evaluation.push(row.pushes[i].aim, &ticks);
      const std::string name = fmt::format("{}-{}", row.model, i);
      plots.push_back(path_plot(name + "-path", row.pushes[i], ticks, capture_.seen, task_.tool));
      plots.push_back(force_plot(name + "-force", ticks, task_.force.proxy.stiffness));
      plots[plots.size() - 2].title += fmt::format(", {}, push {}", row.model, i);
      plots.back().title += fmt::format(", {}, push {}", row.model, i);
      if (options_.worst.empty()) continue;
      written.push_back((std::filesystem::path(options_.worst) / ("push-" + name + ".csv")).string());
      write_trajectory(trajectory_of(ticks), written.back());
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
      "{}: {} straight pushes at Gaussians drawn by lot, from any side, three of the tool's radii deep and "
      "back, and "
      "{} slides of up to 100 mm, half of its thinnest semi-axis deep; seed {}. The seen surface is where "
      "compositing "
      "along the push falls below one half of the light, for the first of {} rays of the tool's "
      "cross-section; "
      "stiffness {:.4g} N/m. Below are the pushes whose force begins farthest from it.",
      options.live.scene.path, task.pushes, options.slides, task.seed, options.rays,
      task.force.proxy.stiffness);
}

}  // namespace

void CaptureOptions::declare(CLI::App& app) {
  constexpr int kMost = 100'000;
  declare_scene(app, live, SceneArgument::kOption);
  add_text(app, "--against", against, "SCENE",
           "of --scene: another capture of the same object, registered alike");
  add_text(app, "--worst", worst, "DIR",
           "of --scene: a folder, for the worst pushes as trajectories for replay");
  add_count(app, "--rays", rays, 1, 10'000,
            "of --scene: of the tool's cross-section that look for the seen surface");
  add_count(app, "--slides", slides, 0, kMost, "of --scene: how many of the pushes are slides, too");
}

void evaluate_capture(const CaptureOptions& options, const CaptureTask& task) {
  if (!(task.force.proxy.stiffness > 0.0))
    throw Error("--stiffness 0: on a capture, forces are held against it");
  check_output(task.csv, {options.live.scene.path, options.against, task.common.config}, "--csv");
  check_output(task.html, {options.live.scene.path, options.against, task.common.config, task.csv}, "--html");
  check_figure_folder(task.svg);
  if (!options.worst.empty() && !std::filesystem::is_directory(options.worst))
    throw Error("--worst {}: is not a folder; make it first", options.worst);
  ResultFile csv(task.csv), html(task.html);
  Study study(options, task);
  std::vector<Row> rows;
  std::vector<Plot> plots;
  std::vector<std::string> written;
  for (const std::string& model : task.models) {
    rows.push_back(study.measure(model));
    for (Plot& plot : study.worst(rows.back(), written)) plots.push_back(std::move(plot));
  }
  csv.write(to_csv(rows), written);
  html.write(page_document("Felt where it is seen?", intro(options, task), plots, to_html(rows)), written);
  write_figures(plots, task.svg, "evaluate", written);
  if (task.common.json) {
    print_json(to_json(rows));
    return;
  }
  print_table(rows);
  for (const std::string& path : written) fmt::print("wrote {}\n", printable(path));
}

}  // namespace palpate::cli
