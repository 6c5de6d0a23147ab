#include <palpate/report/stability_page.h>

#include <algorithm>

#include <fmt/format.h>

#include <palpate/report/markup.h>
#include <palpate/report/page.h>

namespace palpate {
namespace {

using Style = PlotSeries::Style;

/// Values shown for 0 on a logarithmic axis: a tenth of a micrometre, and a nanojoule. Unit: [mm], [mJ].
constexpr double kLeastCycle = 1e-4, kLeastEnergy = 1e-6;

std::vector<std::string> profiles_of(const StabilityTables& tables) {
  std::vector<std::string> names;
  for (const StabilityRow& row : tables.rows)
    if (std::find(names.begin(), names.end(), row.profile) == names.end()) names.push_back(row.profile);
  return names;
}

/// "proxy", "proxy, hold 50 ms"
std::string series_name(const StabilityRow& row) {
  if (row.source == ContactSource::kLoop) return row.model;
  return fmt::format("{}, {} {:g} ms", row.model, to_string(row.source), kMilli * row.delay);
}

/// Returns true for rows in the figures: every model with contact search in the loop, and one with a held
/// force.
bool is_shown(const StabilityTables& tables, const StabilityRow& row) {
  if (row.source == ContactSource::kLoop) return true;
  return row.source == ContactSource::kHold && row.model == tables.rows.front().model;
}

/// Adds a dot for every profile, in at most kColors series, one per model and source.
template <class Value>
void add_dots(Plot& plot, const StabilityTables& tables, const Value& value) {
  const std::vector<std::string>& profiles = plot.x.categories;
  for (const StabilitySummary& summary : summarize(tables.rows)) {
    const StabilityRow& row = *summary.any;
    if (!is_shown(tables, row)) continue;
    const std::string name = series_name(row);
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const PlotSeries& s) { return s.name == name; });
    if (series == plot.series.end()) {
      if (plot.series.size() == PlotSeries::kColors) continue;
      series = plot.series.insert(plot.series.end(),
                                  {name, Style::kDots, static_cast<int>(plot.series.size()), {}});
    }
    const auto at = std::find(profiles.begin(), profiles.end(), row.profile) - profiles.begin();
    if (const auto point = value(static_cast<double>(at), summary)) series->points.push_back(*point);
  }
  const double middle = 0.5 * (static_cast<double>(plot.series.size()) - 1.0);
  for (std::size_t i = 0; i < plot.series.size(); ++i)
    for (PlotPoint& p : plot.series[i].points) p.x += 0.16 * (static_cast<double>(i) - middle);
}

PlotSeries level(const std::string& name, std::size_t profiles, double value) {
  return {
      name, Style::kLine, PlotSeries::kTruth, {{-0.5, value}, {static_cast<double>(profiles) - 0.5, value}}};
}

Plot limit_cycles(const StabilityTables& tables) {
  Plot plot{"cycle",
            "Limit cycle at rest",
            "peak-to-peak motion of the handle, worst of all hands and places",
            {},
            {},
            {}};
  plot.x.categories = profiles_of(tables);
  plot.y = {"peak to peak, mm", true, kLeastCycle, {}, {}};
  add_dots(plot, tables, [](double at, const StabilitySummary& s) {
    return std::optional(PlotPoint(at, std::max(kLeastCycle, kMilli * s.limit_cycle)));
  });
  plot.series.push_back(level("0.05 mm", plot.x.categories.size(), kMilli * kLimitCycleMax));
  return plot;
}

Plot energies(const StabilityTables& tables) {
  Plot plot{"energy", "Net energy output at the port", "worst of all hands and places", {}, {}, {}};
  plot.x.categories = profiles_of(tables);
  plot.y = {"energy, mJ", true, kLeastEnergy, {}, {}};
  add_dots(plot, tables, [](double at, const StabilitySummary& s) {
    return std::optional(PlotPoint(at, std::max(kLeastEnergy, kMilli * s.port_energy)));
  });
  plot.series.push_back(level("1 mJ", plot.x.categories.size(), 1.0));
  return plot;
}

Plot widths(const StabilityTables& tables) {
  Plot plot{"z-width", "Z-width", "largest stable stiffness, range over hands", {}, {}, {}};
  plot.x.categories = profiles_of(tables);
  plot.y = {"stiffness, N/m", true, {}, {}, {}};
  add_dots(plot, tables, [](double at, const StabilitySummary& s) -> std::optional<PlotPoint> {
    if (!s.z_low) return std::nullopt;
    return PlotPoint(at, *s.z_low, *s.z_low, *s.z_high);
  });
  return plot;
}

Plot walls(const StabilityTables& tables) {
  Plot plot{"wall", "Ideal wall", "by bisection, and the theoretical limit (2 b / T, Colgate and Schenkel)",
            {},     {},           {}};
  plot.x.categories = profiles_of(tables);
  plot.y = {"stiffness, N/m", true, {}, {}, {}};
  for (const bool passivity : {false, true}) {
    PlotSeries measured{
        passivity ? "measured, passivity controlled" : "measured", Style::kDots, passivity ? 1 : 0, {}};
    PlotSeries theory{
        passivity ? "in theory, with its damping" : "in theory", Style::kDots, passivity ? 3 : 2, {}};
    for (const WallRow& wall : tables.walls) {
      const auto found = std::find(plot.x.categories.begin(), plot.x.categories.end(), wall.profile);
      if (wall.passivity != passivity || found == plot.x.categories.end()) continue;
      const auto at = static_cast<double>(found - plot.x.categories.begin());
      measured.points.emplace_back(at - 0.08, wall.z_width);
      theory.points.emplace_back(at + 0.08, wall.bound);
    }
    plot.series.push_back(std::move(measured));
    plot.series.push_back(std::move(theory));
  }
  return plot;
}

Plot traces_of(const std::vector<StabilityTrace>& traces, const std::string& subtitle) {
  constexpr std::size_t kEvery = 4;  // [ticks]
  Plot plot{"trace",
            "Pressing, resting, sliding",
            subtitle,
            {"time, s", false, {}, {}, {}},
            {"depth of the handle, mm", false, {}, {}, {}},
            {}};
  for (const StabilityTrace& trace : traces) {
    PlotSeries line{trace.name, Style::kLine, static_cast<int>(plot.series.size()), {}};
    for (std::size_t i = 0; i < trace.ticks.size(); i += kEvery)
      line.points.emplace_back(trace.ticks[i].t, kMilli * trace.ticks[i].depth);
    plot.series.push_back(std::move(line));
  }
  return plot;
}

std::string rows_table(const std::vector<StabilityRow>& rows) {
  std::string html =
      "<div class='table' "
      "tabindex='0'><table>\n<tr><th>profile</th><th>hand</th><th class='name'>model</th><th>contacts</th>"
      "<th>limit cycle mm</th><th>net energy mJ</th><th>contact changes</th><th>force at rest N</th>"
      "<th>force deviation</th><th>fault</th>"
      "<th>Z-width N/m</th></tr>\n";
  std::string last;
  for (const StabilityRow& r : rows) {
    html += fmt::format(
        "<tr{}><td>{}</td><td>{}</td><td class='name'>{}</td><td>{} {:g} "
        "ms</td><td>{:.4f}</td><td>{:.4f}</td>"
        "<td>{}</td><td>{:.2f}</td><td>{:.1f} %</td><td>{}</td><td>{}</td></tr>\n",
        r.profile == last ? "" : " class='new'", markup_escaped(r.profile), hand_text(r.hand),
        markup_escaped(r.model), to_string(r.source), kMilli * r.delay, kMilli * r.limit_cycle,
        kMilli * r.port_energy, r.contact_changes, r.rest_force, 100.0 * r.force_off, traits(r.fault).name,
        r.z_width ? fmt::format("{:.0f}", *r.z_width) : "-");
    last = r.profile;
  }
  return html + "</table></div>\n";
}

std::string walls_table(const std::vector<WallRow>& walls) {
  std::string html =
      "<div class='table' tabindex='0'><table>\n<tr><th>profile</th><th>passivity</th><th>measured N/m</th>"
      "<th>in theory N/m</th><th>ratio</th></tr>\n";
  for (const WallRow& w : walls) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.0f}</td><td>{:.0f}</td><td>{:.3f}</td></tr>\n",
                        markup_escaped(w.profile), w.passivity ? "controlled" : "observed", w.z_width,
                        w.bound, w.z_width / w.bound);
  }
  return html + "</table></div>\n";
}

}  // namespace

std::vector<StabilityTrace> stability_traces(const StabilityStudy& study, const StabilityTables& tables,
                                             std::string& subtitle) {
  std::vector<StabilityTrace> traces;
  const HandProperties& hand = study.hands[study.hands.size() / 2];
  for (const StabilityRow& row : tables.rows) {
    if (row.profile != study.profiles.front() || row.model != study.models.front()) continue;
    if (hand_text(row.hand) != hand_text(hand)) continue;
    const std::string name = row.source == ContactSource::kLoop
                                 ? "contacts searched in the loop"
                                 : fmt::format("{}, {:g} ms", to_string(row.source), 1e3 * row.delay);
    traces.push_back({name, hold_on(trial_of(study, row), study.places.front(), true).ticks});
  }
  subtitle =
      fmt::format("{}, {}, a hand of {}", study.profiles.front(), study.models.front(), hand_text(hand));
  return traces;
}

std::vector<Plot> stability_figures(const StabilityTables& tables, const std::vector<StabilityTrace>& traces,
                                    const std::string& trace_subtitle) {
  return {limit_cycles(tables), energies(tables), traces_of(traces, trace_subtitle), widths(tables),
          walls(tables)};
}

std::string stability_page(const StabilityTables& tables, const std::vector<Plot>& figures,
                           const std::string& setup, const std::string& made) {
  return page_document(
      "Contact stability", setup, figures,
      "<h2>Hand in contact with a scene</h2>\n<p>Worst of all places. Contact search: in the loop; by a "
      "delayed lookahead worker; or with a delayed, held force. Force deviation: relative "
      "deviation from the force with the search in the loop while sliding, 95th "
      "percentile.</p>\n" +
          rows_table(tables.rows) +
          "<h2>Ideal wall</h2>\n<p>Largest stiffness at which a disturbance decays, without dry "
          "friction, encoder steps or a hand: by bisection (measured), and from the "
          "eigenvalues of the sampled loop (in theory).</p>\n" +
          walls_table(tables.walls),
      made);
}

}  // namespace palpate
