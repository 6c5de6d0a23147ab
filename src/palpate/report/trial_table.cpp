#include <palpate/report/trial_table.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <palpate/report/figure_column.h>

namespace palpate {
namespace {

using TrialColumn = FigureColumn<TrialFigures>;

double number(std::size_t n) { return static_cast<double>(n); }

/// Number of the first stroke; NaN if there is none.
double first_of(const std::vector<std::size_t>& strokes) {
  return strokes.empty() ? std::numeric_limits<double>::quiet_NaN() : number(strokes.front());
}

std::string in_mm(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f} mm", kToMm * *value) : "-";
}

using Figures = TrialFigures;
constexpr std::size_t kNarrowest = 6;

const std::vector<TrialColumn>& columns() {
  static const std::vector<TrialColumn> all{
      {"strokes", "strokes", kCount, [](const Figures& f) { return number(f.strokes); }},
      {"slow", nullptr, kCount, [](const Figures& f) { return number(f.slow); }},
      {"silent", "silent", kCount, [](const Figures& f) { return number(f.silent); }},
      {"sunk", "sunk", kCount, [](const Figures& f) { return number(f.sunk); }},
      {"through", "through", kCount, [](const Figures& f) { return number(f.through); }},
      {"stuck", "stuck", kCount, [](const Figures& f) { return number(f.stuck); }},
      {"onsets", "onsets", kCount, [](const Figures& f) { return number(f.onsets); }},
      {"onset_p05_mm", "onset p5", kMm, [](const Figures& f) { return kToMm * f.onset.p05; }},
      {"onset_p50_mm", "p50", kMm, [](const Figures& f) { return kToMm * f.onset.p50; }},
      {"onset_p95_mm", "p95", kMm, [](const Figures& f) { return kToMm * f.onset.p95; }},
      {"true_p50_mm", nullptr, kMm, [](const Figures& f) { return kToMm * f.onset_depth.p50; }},
      {"true_p95_mm", "true p95", kMm, [](const Figures& f) { return kToMm * f.onset_depth.p95; }},
      {"late_p05_mm", "late p5", kMm, [](const Figures& f) { return kToMm * f.late.p05; }},
      {"late_p50_mm", "p50", kMm, [](const Figures& f) { return kToMm * f.late.p50; }},
      {"late_p95_mm", "p95", kMm, [](const Figures& f) { return kToMm * f.late.p95; }},
      {"within_half_mm_percent", "<=0.5 mm %", kCount,
       [](const Figures& f) { return kPercent * f.within_half_mm; }},
      {"within_1mm_percent", "<=1 mm %", kCount, [](const Figures& f) { return kPercent * f.within_1mm; }},
      {"magnitude_p05", "F/kd p5", kMm, [](const Figures& f) { return f.magnitude.p05; }},
      {"magnitude_p50", "p50", kMm, [](const Figures& f) { return f.magnitude.p50; }},
      {"magnitude_p95", "p95", kMm, [](const Figures& f) { return f.magnitude.p95; }},
      {"step_max_n", "step N", kMm, [](const Figures& f) { return f.step.max; }},
      {"tick_p50_us", "tick us", kCount, [](const Figures& f) { return f.tick.p50; }},
      {"tick_p99.9_us", "p99.9", kCount, [](const Figures& f) { return f.tick.p999; }},
      {"tick_max_us", "max", kCount, [](const Figures& f) { return f.tick.max; }},
      {"first_silent", "first silent", kCount, [](const Figures& f) { return first_of(f.silent_strokes); }},
      {"first_sunk", "sunk", kCount, [](const Figures& f) { return first_of(f.sunk_strokes); }},
      {"first_through", "through", kCount, [](const Figures& f) { return first_of(f.through_strokes); }},
      {"first_stuck", "stuck", kCount, [](const Figures& f) { return first_of(f.stuck_strokes); }},
      {"first_late", "late", kCount, [](const Figures& f) { return first_of(f.late_strokes); }},
  };
  return all;
}

}  // namespace

std::string trial_text(const std::vector<TrialRow>& rows) {
  std::string text =
      "silent    strokes with less than a tenth of stiffness times depth deep inside\n"
      "sunk      strokes in which the proxy sinks in by more than half the shortest semi-axis of the tool\n"
      "through   strokes in which the proxy passes through to the far side\n"
      "stuck     strokes that end with a residual force\n"
      "onsets    slow strokes (up to 0.5 m/s) from outside that reach the visible surface\n"
      "onset     force onset of those, relative to the visible surface (negative: before it), mm\n"
      "true      the same relative to the true surface, mm\n"
      "late      onset delay from the visible surface or the first ellipsoid, whichever is later, mm\n"
      "<=        share of onsets that differ from that reference by at most 0.5 and 1 mm, %\n"
      "F/kd      force over stiffness times depth, in slow strokes at flat places\n"
      "step      largest force change in a tick beyond stiffness times the tool motion, in slow strokes, N\n"
      "tick      computation time per tick in contact: median, 99.9th percentile and maximum, us\n"
      "first     numbers of the first failed strokes, for --stroke; late: by more than 1 mm, or no force\n\n";
  text += fmt::format("{:<12} {:<7} {:<9}", "tool", "place", "like");
  for (const TrialColumn& c : columns()) {
    if (c.heading != nullptr) text += fmt::format(" {:>{}}", c.heading, width_of(c, kNarrowest));
  }
  text += "\n";
  for (const TrialRow& row : rows) {
    text += fmt::format("{:<12} {:<7} {:<9}", row.tool, row.place, row.like);
    for (const TrialColumn& c : columns()) {
      if (c.heading != nullptr)
        text += fmt::format(" {:>{}}", text_of(c, row.figures), width_of(c, kNarrowest));
    }
    text += "\n";
  }
  return text;
}

OrderedJson trial_json(const std::vector<TrialRow>& rows) {
  OrderedJson json = OrderedJson::array();
  for (const TrialRow& row : rows) {
    OrderedJson one{{"tool", row.tool}, {"place", row.place}, {"like", row.like}};
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

std::string trial_csv(const std::vector<TrialRow>& rows) {
  std::string text = "tool,place,like" + csv_names(columns()) + "\n";
  for (const TrialRow& row : rows)
    text += fmt::format("{},{},{}{}\n", row.tool, row.place, row.like, csv_figures(columns(), row.figures));
  return text;
}

std::string trial_stroke_text(const TrialRow& row, const TrialStroke& stroke) {
  return fmt::format(
      "{}, {}, {}, stroke {} at {:.3g} m/s: seen {}, touched {}, felt {} on the way, late {}{}{}{}{}\n",
      row.tool, row.place, row.like, stroke.number, stroke.speed, in_mm(stroke.seen), in_mm(stroke.touched),
      in_mm(stroke.felt), in_mm(stroke.late()), stroke.silent ? "; silent" : "", stroke.sunk ? "; sunk" : "",
      stroke.through ? "; through" : "", stroke.stuck ? "; stuck" : "");
}

OrderedJson trial_stroke_json(const TrialRow& row, const TrialStroke& stroke) {
  const auto value = [](const std::optional<double>& v) { return v ? OrderedJson(*v) : OrderedJson(); };
  return {{"tool", row.tool},
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
          {"step", stroke.step}};
}

std::string trial_ticks_csv(const std::vector<TrialTick>& ticks) {
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

void measure_trials(std::vector<TrialRow>& rows, const Progress& progress) {
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

}  // namespace palpate
