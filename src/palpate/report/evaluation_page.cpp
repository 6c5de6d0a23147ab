#include <palpate/report/evaluation_page.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <palpate/report/markup.h>
#include <palpate/report/page.h>

namespace palpate {
namespace {

using Rows = std::vector<EvaluationRow>;
using Style = PlotSeries::Style;

/// Returns the distinct values of `member`, in order of first occurrence.
template <class Member>
auto distinct(const Rows& rows, Member member) {
  std::vector<std::decay_t<decltype(rows.front().*member)>> values;
  for (const EvaluationRow& row : rows) {
    if (std::find(values.begin(), values.end(), row.*member) == values.end()) values.push_back(row.*member);
  }
  return values;
}

template <class Values, class Value>
int index_of(const Values& values, const Value& value) {
  return static_cast<int>(std::find(values.begin(), values.end(), value) - values.begin());
}

/// Draws the figures; a model has the same colour in all of them.
class EvaluationPlots {
 public:
  EvaluationPlots(const Rows& rows, double stiffness)
      : rows_(rows),
        stiffness_(stiffness),
        shapes_(distinct(rows, &EvaluationRow::shape)),
        models_(distinct(rows, &EvaluationRow::model)),
        spacings_(distinct(rows, &EvaluationRow::spacing)) {}

  Plot direction() const {
    Plot plot{
        "direction", "Direction of the force", shown() + "; median and 95th percentile", depth_axis(), {},
        {}};
    plot.y = {"angle from the true normal, degrees", true, {}, 180.0, {}};
    for_shown([&](const EvaluationRow& row, PlotSeries& line) {
      for (const CurvePoint& p : row.figures.direction_at)
        line.points.emplace_back(kToMm * p.at, p.value.p50, p.value.p50, p.value.p95);
      plot.series.push_back(std::move(line));
    });
    return plot;
  }

  Plot force() const {
    Plot plot{
        "force", "Magnitude of the force", shown() + "; median, 5th to 95th percentile", depth_axis(), {},
        {}};
    plot.y = {"force, N", false, 0.0, {}, {}};
    PlotSeries true_line = truth("stiffness x depth");
    for_shown([&](const EvaluationRow& row, PlotSeries& line) {
      for (const CurvePoint& p : row.figures.force_at) {
        line.points.emplace_back(kToMm * p.at, p.value.p50, p.value.p05, p.value.p95);
        if (plot.series.empty()) true_line.points.emplace_back(kToMm * p.at, stiffness_ * p.at);
      }
      plot.series.push_back(std::move(line));
    });
    plot.series.push_back(std::move(true_line));
    return plot;
  }

  Plot slide() const {
    Plot plot{"slide", "Sliding", "", {"distance, mm", false, 0.0, {}, {}}, {"force, N", false, 0.0, {}, {}},
              {}};
    PlotSeries true_line = truth("stiffness x depth");
    for_shown([&](const EvaluationRow& row, PlotSeries& line) {
      const double depth = row.figures.slide_depth;
      plot.subtitle = fmt::format("{}; one slide at 0.1 m/s, {:.3g} mm deep", shown(), kToMm * depth);
      for (const Eigen::Vector2d& p : row.figures.slide) {
        line.points.emplace_back(kToMm * p.x(), p.y());
        if (plot.series.empty()) true_line.points.emplace_back(kToMm * p.x(), stiffness_ * depth);
      }
      plot.series.push_back(std::move(line));
    });
    plot.series.push_back(std::move(true_line));
    return plot;
  }

  Plot step() const {
    constexpr double kShown = 20.0;  // [mm]
    Plot plot{"step",
              "Step of 3 mm",
              "crossed by a ball of 5 mm, no noise; median, 5th to 95th percentile",
              {"distance from the step, mm", false, -kShown, kShown, {}},
              {"height of the proxy's centre, mm", false, {}, {}, {}},
              {}};
    for (const EvaluationRow& row : rows_) {
      if (row.clean_step) draw_crossing(plot, row, row.clean_step->path, kShown);
    }
    PlotSeries true_line = truth("truth");
    constexpr int kPoints = 160;
    for (int k = 0; k <= kPoints; ++k) {
      const double way = kShown * (2.0 * k / kPoints - 1.0);
      true_line.points.emplace_back(way, kToMm * step_truth(way / kToMm));
    }
    plot.series.push_back(std::move(true_line));
    return plot;
  }

  Plot edge() const {
    constexpr double kShown = 40.0;  // [mm]
    Plot plot{"edge",
              "Edge of 90 degrees",
              "crossed half a radius deep; median, 5th to 95th percentile",
              {"distance from the middle of the turn, mm", false, -kShown, kShown, {}},
              {"proxy above the rolling ball, mm", false, {}, {}, {}},
              {}};
    for (const EvaluationRow& row : rows_) {
      if (row.edge) draw_crossing(plot, row, row.edge->error, kShown);
    }
    plot.series.push_back(level("truth", -kShown, kShown, 0.0));
    return plot;
  }

  Plot friction() const {
    Plot plot{"friction",
              "Friction",
              fmt::format("in slides, spacing {:.3g} mm; median, 5th to 95th percentile",
                          kToMm * spacings_.front()),
              {"nominal coefficient", false, 0.0, {}, {}},
              {"measured / nominal", false, {}, {}, {}},
              {}};
    double most = 0.0;
    for (const EvaluationRow& row : rows_) {
      if (row.spacing != spacings_.front() || row.friction_at.empty()) continue;
      if (plot.series.size() == PlotSeries::kColors) break;  // no further colours
      const int color = static_cast<int>(plot.series.size());
      PlotSeries dots{fmt::format("{}, {}", row.model, row.shape), Style::kDots, color, {}};
      for (const auto& [set, measured] : row.friction_at) {
        dots.points.emplace_back(set, measured.p50 / set, measured.p05 / set, measured.p95 / set);
        most = std::max(most, set);
      }
      plot.series.push_back(std::move(dots));
    }
    set_apart(plot, 0.015 * most);
    plot.series.push_back(level("nominal", 0.0, 1.05 * most, 1.0));
    return plot;
  }

  Plot densities() const {
    Plot plot{"densities",
              "Dependence on density",
              fmt::format("force at spacing {:.3g} mm over that at {:.3g} mm, same poses",
                          kToMm * spacings_.back(), kToMm * spacings_.front()),
              shape_axis(),
              {"force ratio", true, {}, {}, {}},
              {}};
    for (const std::string& model : models_) {
      PlotSeries dots{model, Style::kDots, color_of(model), {}};
      for (const EvaluationRow& row : rows_) {
        if (row.model != model || row.spacing != spacings_.back() || !row.denser) continue;
        dots.points.emplace_back(index_of(shapes_, row.shape), row.denser->p50, row.denser->p05,
                                 row.denser->p95);
      }
      plot.series.push_back(std::move(dots));
    }
    set_apart(plot, 0.16);
    plot.series.push_back(
        level("independent of density", -0.5, static_cast<double>(shapes_.size()) - 0.5, 1.0));
    return plot;
  }

 private:
  std::string shown() const {
    return fmt::format("{}, spacing {:.3g} mm", shapes_.front(), kToMm * spacings_.front());
  }

  static PlotAxis depth_axis() { return {"true depth, mm", false, 0.0, {}, {}}; }
  PlotAxis shape_axis() const { return {"", false, {}, {}, shapes_}; }

  static PlotSeries truth(const std::string& name) { return {name, Style::kLine, PlotSeries::kTruth, {}}; }
  static PlotSeries level(const std::string& name, double from, double to, double value) {
    return {name, Style::kLine, PlotSeries::kTruth, {{from, value}, {to, value}}};
  }

  int color_of(const std::string& model) const { return index_of(models_, model) % PlotSeries::kColors; }

  /// The colour `first`, or the next one below, cyclically, that no line of `plot` has; `first` if all are
  /// taken.
  static int free_color(const Plot& plot, int first) {
    for (int k = 0; k < PlotSeries::kColors; ++k) {
      const int color = (PlotSeries::kColors + first - k) % PlotSeries::kColors;
      if (std::none_of(plot.series.begin(), plot.series.end(),
                       [&](const PlotSeries& s) { return s.color == color; }))
        return color;
    }
    return first;
  }

  /// Adds a line for the model and spacing of `row`, for positions within `shown` mm.
  void draw_crossing(Plot& plot, const EvaluationRow& row, const Curve& curve, double shown) const {
    if (curve.empty()) return;
    PlotSeries line{fmt::format("{}, {:.3g} mm", row.model, kToMm * row.spacing),
                    Style::kLine,
                    free_color(plot, color_of(row.model)),
                    {}};
    for (const CurvePoint& p : curve) {
      if (std::abs(kToMm * p.at) <= shown)
        line.points.emplace_back(kToMm * p.at, kToMm * p.value.p50, kToMm * p.value.p05, kToMm * p.value.p95);
    }
    plot.series.push_back(std::move(line));
  }

  /// Calls `visit(row, series)` for each row of the shape and spacing that are shown.
  template <class Visit>
  void for_shown(const Visit& visit) const {
    for (const EvaluationRow& row : rows_) {
      if (row.shape != shapes_.front() || row.spacing != spacings_.front()) continue;
      PlotSeries line{row.model, Style::kLine, color_of(row.model), {}};
      visit(row, line);
    }
  }

  /// Shifts the series sideways, so that dots at one position are beside each other.
  static void set_apart(Plot& plot, double distance) {
    const double middle = 0.5 * (static_cast<double>(plot.series.size()) - 1.0);
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      for (PlotPoint& p : plot.series[i].points) p.x += distance * (static_cast<double>(i) - middle);
    }
  }

  const Rows& rows_;
  double stiffness_;
  std::vector<std::string> shapes_, models_;
  std::vector<double> spacings_;
};

std::string table_of(const EvaluationSection& section, const Rows& rows) {
  std::string html =
      "<div class='table' tabindex='0'><table>\n<tr><th>shape</th><th>spacing</th><th "
      "class='name'>model</th>";
  for (const EvaluationColumn& c : section.columns)
    html += fmt::format("<th>{}</th>", markup_escaped(c.heading));
  html += "</tr>\n";
  std::string last;
  for (const EvaluationRow& row : rows) {
    if (!section.has(row)) continue;
    html += fmt::format("<tr{}><td>{}</td><td>{:.3g} mm</td><td class='name'>{}</td>",
                        row.shape == last ? "" : " class='new'", markup_escaped(row.shape),
                        kToMm * row.spacing, markup_escaped(row.model));
    for (const EvaluationColumn& c : section.columns)
      html += fmt::format("<td>{}</td>", markup_escaped(text_of(c, row)));
    html += "</tr>\n";
    last = row.shape;
  }
  return html + "</table></div>\n";
}

}  // namespace

std::vector<Plot> evaluation_figures(const Rows& rows, double stiffness) {
  const EvaluationPlots figures(rows, stiffness);
  return {figures.direction(), figures.force(),    figures.slide(),    figures.step(),
          figures.edge(),      figures.friction(), figures.densities()};
}

std::string evaluation_page(const Rows& rows, const std::vector<Plot>& figures, const std::string& setup,
                            const std::string& made) {
  std::string tables;
  for (const EvaluationSection& section : evaluation_sections()) {
    if (std::none_of(rows.begin(), rows.end(), [&](const EvaluationRow& r) { return section.has(r); }))
      continue;
    tables += fmt::format("<h2>{}</h2>\n<p>{}</p>\n{}", markup_escaped(section.title),
                          markup_escaped(section.note), table_of(section, rows));
  }
  return page_document("Accuracy of the force models", setup, figures, tables, made);
}

}  // namespace palpate
