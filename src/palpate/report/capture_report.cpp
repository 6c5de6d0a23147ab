#include <palpate/report/capture_report.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include <palpate/report/figure_column.h>
#include <palpate/report/markup.h>

namespace palpate {
namespace {

constexpr std::size_t kWorst = 5;

using CaptureColumn = FigureColumn<CaptureRow>;

constexpr const char* kNote =
    "Silent: the force is below a tenth of stiffness times depth. Avoidably silent: silent although an\n"
    "ellipsoid is in contact and a rigid frictionless tool kept outside the visible surface would not be.\n";

double of_likeness(const CaptureRow& row, double (*value)(const CaptureLikeness&)) {
  return row.likeness ? value(*row.likeness) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

const std::vector<FigureColumn<CaptureRow>>& capture_columns() {
  static const std::vector<CaptureColumn> all{
      {"pushes", "pushes", "{:.0f}",
       [](const CaptureRow& r) { return static_cast<double>(r.figures.pushes); }},
      {"onset_within_5mm_percent", "onset within 5 mm of the visible surface, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.onset_within; }},
      {"late_percent", "onset over 5 mm late or missing, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.late; }},
      {"early_percent", "onset over 5 mm early, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.early; }},
      {"onset_p50_mm", "onset depth, median, mm", "{:.2f}",
       [](const CaptureRow& r) { return kToMm * r.figures.onset.p50; }},
      {"silent_5mm_percent", "silent at 5 mm depth, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.silent_5mm; }},
      {"silent_10mm_percent", "silent at 10 mm depth, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.silent_10mm; }},
      {"avoidable_5mm_percent", "avoidably silent at 5 mm depth, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.avoidable_5mm; }},
      {"untouched_percent", "force above 1 N before first contact, %", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.untouched; }},
      {"push_step_p50_n", "largest force step, median push, N", "{:.3f}",
       [](const CaptureRow& r) { return r.figures.push_step.p50; }},
      {"push_step_max_n", "largest force step, worst push, N", "{:.3f}",
       [](const CaptureRow& r) { return r.figures.push_step.max; }},
      {"slides", "slides", "{:.0f}",
       [](const CaptureRow& r) { return static_cast<double>(r.figures.slides); }},
      {"slide_strong_percent", "slides: force above three times stiffness x depth, % of ticks", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.slide_strong; }},
      {"slide_silent_percent", "slides: silent, % of ticks", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.slide_silent; }},
      {"slide_silent_touched_percent", "slides: silent in contact with an ellipsoid, % of ticks", "{:.1f}",
       [](const CaptureRow& r) { return kPercent * r.figures.slide_silent_touched; }},
      {"slide_step_p50_n", "largest force step, median slide, N", "{:.3f}",
       [](const CaptureRow& r) { return r.figures.slide_step.p50; }},
      {"slide_step_max_n", "largest force step, worst slide, N", "{:.3f}",
       [](const CaptureRow& r) { return r.figures.slide_step.max; }},
      {"tick_p50_us", "computation time per tick, median, us", "{:.1f}",
       [](const CaptureRow& r) { return r.figures.tick.p50; }},
      {"tick_p99.9_us", "computation time per tick, p99.9, us", "{:.1f}",
       [](const CaptureRow& r) { return r.figures.tick.p999; }},
      {"first_touch_within_5mm_percent", "first ellipsoid contact within 5 mm of the visible surface, %",
       "{:.1f}", [](const CaptureRow& r) { return kPercent * r.figures.touched_within; }},
      {"against_p10", "force in the other capture / force in this one, p10", "{:.2f}",
       [](const CaptureRow& r) { return of_likeness(r, [](const CaptureLikeness& l) { return l.p10; }); }},
      {"against_p90", "force in the other capture / force in this one, p90", "{:.2f}",
       [](const CaptureRow& r) { return of_likeness(r, [](const CaptureLikeness& l) { return l.p90; }); }},
      {"silent_in_one_percent", "silent at 5 mm depth in one capture only, %", "{:.1f}",
       [](const CaptureRow& r) {
         return of_likeness(r, [](const CaptureLikeness& l) { return kPercent * l.silent_in_one; });
       }},
  };
  return all;
}

namespace {

bool is_shown(const CaptureColumn& column, const std::vector<CaptureRow>& rows) {
  return std::ranges::any_of(rows, [&](const CaptureRow& row) { return !std::isnan(column.value(row)); });
}

/// Error of a push: distance from the seen surface to where its force begins; above all others if it never
/// does.
double error_of(const CapturePush& push) {
  return push.onset ? std::abs(*push.onset) : std::numeric_limits<double>::max();
}

std::string onset_text(const CapturePush& push) {
  if (!push.onset) return "none";
  return fmt::format("{:.1f} mm {} the visible surface", kToMm * std::abs(*push.onset),
                     *push.onset < 0.0 ? "before" : "behind");
}

}  // namespace

std::string capture_text(const std::vector<CaptureRow>& rows) {
  std::string text;
  text += fmt::format("{:<66}", "");
  for (const CaptureRow& row : rows) text += fmt::format(" {:>8}", row.model);
  text += '\n';
  for (const CaptureColumn& column : capture_columns()) {
    if (!is_shown(column, rows)) continue;
    text += fmt::format("{:<66}", column.heading);
    for (const CaptureRow& row : rows) text += fmt::format(" {:>8}", text_of(column, row));
    text += '\n';
  }
  return text + "\n" + kNote;
}

OrderedJson capture_json(const std::vector<CaptureRow>& rows) {
  OrderedJson json = OrderedJson::array();
  for (const CaptureRow& row : rows) {
    OrderedJson one{{"model", row.model}};
    put_figures(capture_columns(), row, one);
    json.push_back(std::move(one));
  }
  return json;
}

std::string capture_csv(const std::vector<CaptureRow>& rows) {
  std::string text = "model" + csv_names(capture_columns()) + "\n";
  for (const CaptureRow& row : rows) text += row.model + csv_figures(capture_columns(), row) + "\n";
  return text;
}

std::string capture_html(const std::vector<CaptureRow>& rows) {
  std::string html = "<div class='table' tabindex='0'><table>\n<tr><th></th>";
  for (const CaptureRow& row : rows) html += fmt::format("<th>{}</th>", markup_escaped(row.model));
  html += "</tr>\n";
  for (const CaptureColumn& column : capture_columns()) {
    if (!is_shown(column, rows)) continue;
    html += fmt::format("<tr><td>{}</td>", markup_escaped(column.heading));
    for (const CaptureRow& row : rows) html += fmt::format("<td>{}</td>", text_of(column, row));
    html += "</tr>\n";
  }
  return html + "</table></div>\n<p>" + kNote + "</p>\n";
}

std::vector<std::size_t> worst_pushes(const std::vector<CapturePush>& pushes) {
  std::vector<std::size_t> order(pushes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return error_of(pushes[a]) > error_of(pushes[b]); });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

Plot capture_path_plot(const std::string& name, const CapturePush& push,
                       const std::vector<CaptureTick>& ticks, const SeenSurface& seen, const Tool& tool) {
  const CaptureAim& aim = push.aim;
  const Eigen::Vector3d aside = aim.along.unitOrthogonal();
  const double shown = 3.0 * tool.radius();
  Plot plot{name,
            "Visible surface and paths",
            fmt::format("in a plane through the push; force onset: {}", onset_text(push)),
            {"lateral position, mm", false, -kToMm * shown, kToMm * shown, {}},
            {"height above first contact with the visible surface, mm", false, {}, {}, {}},
            {}};
  const Eigen::Vector3d touch = aim.from + aim.seen * aim.along;
  const auto image = [&](const Eigen::Vector3d& p) {
    return PlotPoint(kToMm * (p - touch).dot(aside), -kToMm * (p - touch).dot(aim.along));
  };
  PlotSeries surface{"visible surface", PlotSeries::Style::kDots, PlotSeries::kTruth, {}};
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
  PlotSeries outline{"tool at first contact", PlotSeries::Style::kLine, 2, {}};
  constexpr int kCorners = 72;
  const Ellipsoid solid = tool.parts().front().at({touch, Eigen::Quaterniond::Identity()});
  for (int k = 0; k <= kCorners; ++k) {
    // Silhouette of the tool, viewed along the normal of the plane.
    const double angle = 2.0 * std::numbers::pi * k / kCorners;
    const Eigen::Vector3d out = std::cos(angle) * aside + std::sin(angle) * aim.along;
    const Eigen::Vector3d n = solid.axes.transpose() * out;
    outline.points.push_back(image(solid.center + solid.axes * n / n.norm()));
  }
  plot.series = {std::move(surface), std::move(hand), std::move(proxy), std::move(outline)};
  return plot;
}

Plot capture_force_plot(const std::string& name, const std::vector<CaptureTick>& ticks, double stiffness) {
  Plot plot{name,
            "Force",
            "approach and retreat",
            {"depth below the visible surface, mm", false, {}, {}, {}},
            {"force, N", false, 0.0, {}, {}},
            {}};
  PlotSeries felt{"rendered force", PlotSeries::Style::kLine, 0, {}},
      spring{"stiffness x depth", PlotSeries::Style::kLine, PlotSeries::kTruth, {}};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    felt.points.emplace_back(kToMm * ticks[i].depth, ticks[i].force.norm());
    if (i < ticks.size() / 2)
      spring.points.emplace_back(kToMm * ticks[i].depth, stiffness * std::max(0.0, ticks[i].depth));
  }
  plot.series = {std::move(felt), std::move(spring)};
  return plot;
}

CaptureRow capture_row(const std::string& model, CaptureEvaluation& evaluation,
                       const std::vector<CaptureAim>& aims, std::size_t slides, const Progress& progress) {
  CaptureRow row{model, {}, {}, {}};
  std::vector<CaptureSlide> slid;
  const std::size_t slide_count = std::min(aims.size(), slides);
  const auto work = static_cast<double>(aims.size() + slide_count);
  for (const CaptureAim& aim : aims) {
    row.pushes.push_back(evaluation.push(aim));
    report(progress, "pushing, " + model, 0.999 * static_cast<double>(row.pushes.size()) / work);
  }
  for (std::size_t i = 0; i < slide_count; ++i) {
    slid.push_back(evaluation.slide(aims[i]));
    report(progress, "sliding, " + model, static_cast<double>(aims.size() + i + 1) / work);
  }
  row.figures = evaluation.figures(row.pushes, slid);
  return row;
}

Trajectory capture_trajectory(const std::vector<CaptureTick>& ticks) {
  constexpr double kPeriod = 1e-3;
  Trajectory trajectory;
  for (std::size_t i = 0; i < ticks.size(); ++i)
    trajectory.push_back(
        {kPeriod * static_cast<double>(i), {ticks[i].tool, Eigen::Quaterniond::Identity()}, {}});
  return trajectory;
}

}  // namespace palpate
