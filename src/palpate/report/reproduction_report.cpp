#include <palpate/report/reproduction_report.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/report/markup.h>
#include <palpate/report/page.h>
#include <palpate/report/stability_table.h>

namespace palpate {
namespace {

using Style = PlotSeries::Style;
using TickValue = std::function<double(const ReproductionTick&)>;

constexpr std::size_t kIntervals = 400;     // intervals of a line
constexpr std::size_t kCloudDots = 1500;    // dots of a scene
constexpr double kWide = 4.4, kHigh = 2.2;  // extent of Fig. 4, to about one scale. [m]

std::string figure_text(double value) {
  if (std::isnan(value)) return "-";
  return value != 0.0 && std::abs(value) < 0.01 ? fmt::format("{:.2g}", value) : fmt::format("{:.4g}", value);
}

std::string bound_text(const Claim& claim) {
  return fmt::format("{} {:g}", claim.bound == Claim::Bound::kAtMost ? "<=" : ">=", claim.limit);
}

const char* verdict(const Claim& claim, double value) {
  if (std::isnan(value)) return "unknown";
  return claim.holds(value) ? "met" : "not met";
}

/// "density, admittance", "proxy, impedance, held 50 ms"
std::string run_name(const ReproductionRun& run) {
  const std::string held = run.stall > 0.0 ? fmt::format(", held {:g} ms", kMilli * run.stall) : "";
  return fmt::format("{}, {}{}", run.model, to_string(run.device), held);
}

/// Summary of a run: the worst of its contacts.
struct RunFigures {
  int felt = 0, bounces = 0;
  double force = 0.0, user_off = 0.0, swing = 0.0, overshoot = 0.0, per_depth_low = 1e300,
         per_depth_high = 0.0;
  /// NaN without a contact whose true normal and force are known. Unit: [deg].
  double off = std::numeric_limits<double>::quiet_NaN();
};

RunFigures figures_of(const ReproductionRun& run) {
  RunFigures f;
  for (const ReproductionContact& c : run.contacts) {
    f.felt += static_cast<int>(!std::isnan(c.begins));
    f.bounces += c.bounces;
    f.force = std::max(f.force, c.force);
    if (c.force > 0.0) f.user_off = std::max(f.user_off, std::abs(c.user - c.force) / c.force);
    f.swing = std::max(f.swing, c.swing);
    f.overshoot = std::max(f.overshoot, c.overshoot);
    f.off = std::fmax(f.off, c.off * 180.0 / std::numbers::pi);
    if (std::isnan(c.depth)) continue;
    f.per_depth_low = std::min(f.per_depth_low, c.force / c.depth);
    f.per_depth_high = std::max(f.per_depth_high, c.force / c.depth);
  }
  return f;
}

std::string per_depth_text(const RunFigures& f) {
  return f.per_depth_high > 0.0 ? fmt::format("{:.0f} to {:.0f}", f.per_depth_low, f.per_depth_high) : "-";
}

std::string angle_text(const RunFigures& f) { return std::isnan(f.off) ? "-" : fmt::format("{:.1f}", f.off); }

std::string faults_text(const ReproductionRun& run) {
  return run.faults.empty() ? "none" : fmt::format("{}", fmt::join(run.faults, ", "));
}

std::vector<PlotMark> marks_of(const ReproductionRun& run) {
  std::vector<PlotMark> marks;
  char letter = 'a';
  for (const ReproductionContact& contact : run.contacts)
    marks.push_back({contact.begins, fmt::format("t{}", letter++)});
  return marks;
}

/// Line of the largest and the least value of each interval of ticks, so that no spike is lost.
PlotSeries line_of(const ReproductionRun& run, const std::string& name, int color, const TickValue& value) {
  PlotSeries line{name, Style::kLine, color, {}};
  const std::size_t count = run.ticks.size(), each = std::max<std::size_t>(1, count / kIntervals);
  for (std::size_t first = 0; first < count; first += each) {
    const auto begin = run.ticks.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = run.ticks.begin() + static_cast<std::ptrdiff_t>(std::min(count, first + each));
    const auto less = [&](const auto& a, const auto& b) { return value(a) < value(b); };
    auto [low, high] = std::minmax_element(begin, end, less);
    if (high < low) std::swap(low, high);
    line.points.emplace_back(low->t, value(*low));
    if (high != low) line.points.emplace_back(high->t, value(*high));
  }
  return line;
}

Plot row_of(const ReproductionRun& run, const std::string& name, const std::string& title, PlotAxis y) {
  Plot plot{name + "-" + run.model, title, run_name(run), {"time, s", false, {}, {}, {}}, std::move(y), {}};
  plot.marks = marks_of(run);
  return plot;
}

Plot counts(const ReproductionRun& run) {
  Plot plot = row_of(run, "counts", "Collision count", {"Gaussians", true, PlotAxis::kLeastCount, {}, {}});
  const auto count = [](std::size_t n) { return std::max(PlotAxis::kLeastCount, static_cast<double>(n)); };
  plot.series = {line_of(run, "candidates", 0, [=](const auto& t) { return count(t.candidates); }),
                 line_of(run, "filtered", 2, [=](const auto& t) { return count(t.filtered); }),
                 line_of(run, "colliding", 1, [=](const auto& t) { return count(t.colliding); })};
  return plot;
}

Plot vector_row(const ReproductionRun& run, const std::string& name, const std::string& title,
                const std::function<Eigen::Vector3d(const ReproductionTick&)>& vector) {
  Plot plot = row_of(run, name, title, {"N", false, {}, {}, {}});
  const char* const axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis)
    plot.series.push_back(line_of(run, axes[axis], axis, [=](const auto& t) { return vector(t)[axis]; }));
  return plot;
}

Plot times(const ReproductionRun& run) {
  Plot plot = row_of(run, "times", "Computation time", {"us", true, 0.5, {}, {}});
  plot.series = {line_of(run, "processor time", 0, [](const auto& t) { return std::max(0.5, t.cpu_us); }),
                 {"1 kHz", Style::kLine, PlotSeries::kTruth, {{0.0, 1e3}, {run.ticks.back().t, 1e3}}},
                 {"50 ms", Style::kLine, 1, {{0.0, 5e4}, {run.ticks.back().t, 5e4}}}};
  return plot;
}

Plot view(const ReproductionRun& run, const RoomPath& path, const EllipsoidScene& scene,
          const std::string& name, const std::string& title, int across, int up,
          const Eigen::Vector3d& middle) {
  const char* const axes[] = {"x, m", "y, m", "z, m"};
  Plot plot{name,
            title,
            run_name(run),
            {axes[across], false, middle[across] - 0.5 * kWide, middle[across] + 0.5 * kWide, {}},
            {axes[up], false, middle[up] - 0.5 * kHigh, middle[up] + 0.5 * kHigh, {}},
            {}};
  PlotSeries cloud{"", Style::kCloud, PlotSeries::kTruth, {}};
  const std::size_t each = std::max<std::size_t>(1, scene.size() / kCloudDots);
  for (std::size_t i = 0; i < scene.size(); i += each)
    cloud.points.emplace_back(scene.ellipsoids[i].center[across], scene.ellipsoids[i].center[up]);
  PlotSeries way{"tool", Style::kLine, 0, {}}, places{"contacts", Style::kDots, 1, {}};
  for (std::size_t i = 0; i < run.ticks.size(); i += 40)
    way.points.emplace_back(run.ticks[i].tool[across], run.ticks[i].tool[up]);
  for (const RoomTouch& touch : path.touches)
    places.points.emplace_back(touch.place.touch.position[across], touch.place.touch.position[up]);
  plot.series = {std::move(cloud), std::move(way), std::move(places)};
  return plot;
}

std::string claims_table(const ReproductionResult& result) {
  std::string html =
      "<div class='table' tabindex='0'><table>\n<tr><th class='text'>statement</th><th>value in the "
      "paper</th><th class='text'>measured quantity</th><th>criterion</th><th>paper's pipeline</th>"
      "<th>default</th><th>verdict</th><th>margin</th></tr>\n";
  for (const Claim& c : result.claims) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}, "
        "{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        markup_escaped(c.words), markup_escaped(c.figure), markup_escaped(c.what),
        markup_escaped(bound_text(c)), figure_text(c.paper), verdict(c, c.paper), figure_text(c.own),
        verdict(c, c.own), figure_text(c.ratio(c.own)));
  }
  return html + "</table></div>\n";
}

std::string runs_table(const ReproductionResult& result) {
  std::string html =
      "<div class='table' tabindex='0'><table>\n<tr><th>run</th><th>contacts</th><th>force at rest N</th>"
      "<th>user force deviation</th><th>oscillation mm</th><th>overshoot mm</th><th>bounces</th>"
      "<th>angle to true normal, degrees</th><th>N per metre of true depth</th><th>net energy mJ</th>"
      "<th>ticks at a device limit</th><th>faults</th></tr>\n";
  for (const ReproductionRun& run : result.runs) {
    const RunFigures f = figures_of(run);
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.1f} "
        "%</td><td>{:.3f}</td><td>{:.2f}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{:.3f}</td><td>{}</td><td>{}</td></tr>\n",
        markup_escaped(run_name(run)), f.felt, f.force, 100.0 * f.user_off, kMilli * f.swing,
        kMilli * f.overshoot, f.bounces, angle_text(f), per_depth_text(f), kMilli * run.port_energy,
        run.held_ticks, faults_text(run));
  }
  return html + "</table></div>\n";
}

OrderedJson number_or_null(double value) { return std::isfinite(value) ? OrderedJson(value) : OrderedJson(); }

OrderedJson contact_json(const ReproductionContact& c) {
  return {{"begins", number_or_null(c.begins)},
          {"colliding", c.colliding},
          {"force", c.force},
          {"user_force", c.user},
          {"direction", vector_json(c.direction)},
          {"swing_mm", kMilli * c.swing},
          {"overshoot_mm", kMilli * c.overshoot},
          {"bounces", c.bounces},
          {"true_depth_mm", number_or_null(kMilli * c.depth)},
          {"off_deg", number_or_null(c.off * 180.0 / std::numbers::pi)}};
}

}  // namespace

std::string reproduction_text(const ReproductionResult& result) {
  std::string text = result.setup + "\n\n";
  for (const Claim& c : result.claims) {
    fmt::format_to(
        std::back_inserter(text), "{}  [{}]\n    {}: paper's pipeline {} ({}), default {} ({}{})\n", c.words,
        c.figure, c.what, figure_text(c.paper), verdict(c, c.paper), figure_text(c.own), verdict(c, c.own),
        std::isnan(c.ratio(c.own)) ? "" : fmt::format(", margin {}x", figure_text(c.ratio(c.own))));
  }
  fmt::format_to(std::back_inserter(text),
                 "\n{:<32} {:>8} {:>7} {:>9} {:>9} {:>12} {:>8} {:>9} {:>12} {:>10}  {}\n", "run", "contacts",
                 "rest N", "user dev", "osc mm", "overshoot mm", "bounces", "angle deg", "N/m of depth",
                 "energy mJ", "faults");
  for (const ReproductionRun& run : result.runs) {
    const RunFigures f = figures_of(run);
    fmt::format_to(std::back_inserter(text),
                   "{:<32} {:>8} {:>7.2f} {:>8.1f}% {:>9.3f} {:>12.2f} {:>8} {:>9} {:>12} {:>10.3f}  {}\n",
                   run_name(run), f.felt, f.force, 100.0 * f.user_off, kMilli * f.swing, kMilli * f.overshoot,
                   f.bounces, angle_text(f), per_depth_text(f), kMilli * run.port_energy, faults_text(run));
  }
  return text;
}

OrderedJson reproduction_json(const ReproductionResult& result) {
  OrderedJson json{{"setup", result.setup}};
  for (const Claim& c : result.claims) {
    json["claims"].push_back({{"paper", c.words},
                              {"figure", c.figure},
                              {"measured", c.what},
                              {"bound", bound_text(c)},
                              {"paper_pipeline", number_or_null(c.paper)},
                              {"default", number_or_null(c.own)},
                              {"met", std::isnan(c.own) ? OrderedJson() : OrderedJson(c.holds(c.own))},
                              {"ratio", number_or_null(c.ratio(c.own))}});
  }
  for (const ReproductionRun& run : result.runs) {
    OrderedJson contacts = OrderedJson::array();
    for (const ReproductionContact& contact : run.contacts) contacts.push_back(contact_json(contact));
    json["runs"].push_back({{"model", run.model},
                            {"device", to_string(run.device)},
                            {"held_ms", kMilli * run.stall},
                            {"port_energy_mj", kMilli * run.port_energy},
                            {"held_ticks", run.held_ticks},
                            {"faults", run.faults},
                            {"contacts", contacts}});
  }
  return json;
}

std::string reproduction_csv(const ReproductionResult& result) {
  std::string csv =
      "run,t,x,y,z,candidates,filtered,colliding,fx,fy,fz,ufx,ufy,ufz,cpu_us,wall_us,true_depth\n";
  for (std::size_t r = 0; r < std::min<std::size_t>(2, result.runs.size()); ++r) {
    for (const ReproductionTick& t : result.runs[r].ticks) {
      fmt::format_to(std::back_inserter(csv),
                     "{},{:.3f},{:.6g},{:.6g},{:.6g},{},{},{},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:."
                     "4g},{:.4g},{}\n",
                     result.runs[r].model, t.t, t.tool.x(), t.tool.y(), t.tool.z(), t.candidates, t.filtered,
                     t.colliding, t.force.x(), t.force.y(), t.force.z(), t.user.x(), t.user.y(), t.user.z(),
                     t.cpu_us, t.wall_us, std::isnan(t.depth) ? "" : fmt::format("{:.6g}", t.depth));
    }
  }
  return csv;
}

std::vector<Plot> reproduction_figures(const ReproductionResult& result, const EllipsoidScene& scene) {
  const ReproductionRun& own = result.runs[1];
  Eigen::AlignedBox3d box;
  for (const ReproductionTick& tick : own.ticks) box.extend(tick.tool);
  std::vector<Plot> plots{
      view(own, result.path, scene, "path-above", "TCP path from above (Fig. 4)", 0, 1, box.center()),
      view(own, result.path, scene, "path-side", "TCP path from the side", 0, 2, box.center())};
  for (std::size_t r = 0; r < 2; ++r) plots.push_back(counts(result.runs[r]));
  for (std::size_t r = 0; r < 2; ++r)
    plots.push_back(
        vector_row(result.runs[r], "force", "Repulsive force", [](const auto& t) { return t.force; }));
  for (std::size_t r = 0; r < 2; ++r)
    plots.push_back(vector_row(result.runs[r], "user", "User force", [](const auto& t) { return t.user; }));
  for (std::size_t r = 0; r < 2; ++r) plots.push_back(times(result.runs[r]));
  return plots;
}

std::string reproduction_page(const ReproductionResult& result, const std::vector<Plot>& figures,
                              const std::string& made) {
  return page_document(
      "Reproduction of the paper's evaluation", result.setup, figures,
      "<h2>Statements of the paper and measured values</h2>\n<p>Statements of section V. Verdict and margin "
      "are those of the default. Margin: factor by which the measured value satisfies the criterion.</p>\n" +
          claims_table(result) +
          "<h2>Further runs</h2>\n<p>The same path with an impedance device that has the mass and damping of "
          "the admittance device's handle in free space; and with forces that take the stated time to "
          "compute and are held meanwhile. Values are at rest, worst of all places.<br/>\n"
          "Contacts: places at which a force occurs.<br/>\n"
          "User force deviation: relative difference of user force and scene force, due to friction.<br/>\n"
          "Oscillation: peak-to-peak motion about a linear fit of the tool's path.<br/>\n"
          "Overshoot: largest depth beyond the rest position.<br/>\n"
          "Bounces: rebounds that end the force before rest, total of all places.<br/>\n"
          "Angle to true normal, N per metre of true depth: with respect to the surface that the scene was "
          "made of.<br/>\n"
          "Ticks at a device limit: ticks in which a limit of the device held its motion.</p>\n" +
          runs_table(result),
      made, true);
}

}  // namespace palpate
