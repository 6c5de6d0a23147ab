#include <palpate/report/evaluation_table.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

namespace palpate {
namespace {

using Row = EvaluationRow;
using Column = EvaluationColumn;
using Section = EvaluationSection;

constexpr double kToUm = 1e6;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

constexpr const char *kShare = "{:.3f}", *kUs = "{:.1f}";
constexpr std::size_t kNarrowestColumn = 7;

Section pressed() {
  return {
      "Presses along the normal",
      "Depth of the first force (onset), mm. Deeper than 4 mm: angle of the force to the true normal,\n"
      "degrees; |F| over stiffness times true depth; ticks without force (silent); ticks with an\n"
      "attractive force (pulling).",
      {{"direction_p50_deg", "angle p50", "{:.1f}", [](const Row& r) { return r.figures.direction.p50; }},
       {"direction_p95_deg", "p95", "{:.1f}", [](const Row& r) { return r.figures.direction.p95; }},
       {"direction_p99_deg", "p99", "{:.1f}", [](const Row& r) { return r.figures.direction.p99; }},
       {"magnitude_p05", "F/kd p5", "{:.2f}", [](const Row& r) { return r.figures.magnitude.p05; }},
       {"magnitude_p50", "p50", "{:.2f}", [](const Row& r) { return r.figures.magnitude.p50; }},
       {"magnitude_p95", "p95", "{:.2f}", [](const Row& r) { return r.figures.magnitude.p95; }},
       {"onset_p50_mm", "onset", kMm, [](const Row& r) { return kToMm * r.figures.onset.p50; }},
       {"silent", "silent", kCount, [](const Row& r) { return static_cast<double>(r.figures.silent); }},
       {"flipped", "pulling", kCount, [](const Row& r) { return static_cast<double>(r.figures.flipped); }}}};
}

Section seen() {
  return {
      "Relative to the visible surface",
      "The visible surface is where the transmittance along the press falls below one half. True depth of\n"
      "the tool at first contact with it, mm; |F| over stiffness times the depth below that contact.",
      {{"seen_p50_mm", "contact at", kMm, [](const Row& r) { return kToMm * r.figures.seen.p50; }},
       {"magnitude_seen_p05", "F/kd p5", "{:.2f}", [](const Row& r) { return r.figures.magnitude_seen.p05; }},
       {"magnitude_seen_p50", "p50", "{:.2f}", [](const Row& r) { return r.figures.magnitude_seen.p50; }},
       {"magnitude_seen_p95", "p95", "{:.2f}", [](const Row& r) { return r.figures.magnitude_seen.p95; }}}};
}

Section moved() {
  return {
      "Slides, loops and push-through",
      "Slides: standard deviation of |F| over its mean (ripple); largest force change in 1 ms, N (jump).\n"
      "Loops: work per closed circle relative to the spring energy. Pushes that passed through the surface,\n"
      "of all and of those at 2 m/s (fast).",
      {{"ripple_p50", "ripple", kShare, [](const Row& r) { return r.figures.ripple.p50; }},
       {"ripple_p95", "p95", kShare, [](const Row& r) { return r.figures.ripple.p95; }},
       {"jump_max_n", "jump", kShare, [](const Row& r) { return r.figures.jump.max; }},
       {"loop_p50", "loop", "{:.1e}", [](const Row& r) { return r.figures.loop.p50; }},
       {"loop_max", "max", "{:.1e}", [](const Row& r) { return r.figures.loop.max; }},
       {"pushes", "pushes", kCount, [](const Row& r) { return static_cast<double>(r.figures.pushes); }},
       {"through", "through", kCount, [](const Row& r) { return static_cast<double>(r.figures.through); }},
       {"fast", "fast", kCount, [](const Row& r) { return static_cast<double>(r.figures.fast); }},
       {"fast_through", "through", kCount,
        [](const Row& r) { return static_cast<double>(r.figures.fast_through); }}}};
}

Section rubbed() {
  return {"Friction",
          "Friction over normal force, per slide; largest creep of the proxy in 10 s of rest, um.",
          {{"friction_p05", "p5", kShare, [](const Row& r) { return r.figures.friction.p05; }},
           {"friction_p50", "p50", kShare, [](const Row& r) { return r.figures.friction.p50; }},
           {"friction_p95", "p95", kShare, [](const Row& r) { return r.figures.friction.p95; }},
           {"creep_max_um", "creep", "{:.3f}", [](const Row& r) { return kToUm * r.figures.creep.max; }}}};
}

Section denser() {
  return {
      "Dependence on density",
      "Ratio of |F| to |F| at the first spacing, same poses.",
      {{"force_ratio_p05", "F/F p5", "{:.2f}", [](const Row& r) { return r.denser ? r.denser->p05 : kNone; }},
       {"force_ratio_p50", "p50", "{:.2f}", [](const Row& r) { return r.denser ? r.denser->p50 : kNone; }},
       {"force_ratio_p95", "p95", "{:.2f}", [](const Row& r) { return r.denser ? r.denser->p95 : kNone; }}}};
}

double step_mm(const std::optional<StepResponse>& step, double Spread::*quantile) {
  return step ? kToMm * (step->felt.*quantile) : kNone;
}

Section stepped() {
  return {"Crossing of a step of 3 mm by a ball of 5 mm",
          "Largest rise of the proxy within 15 mm, mm, without noise, and the distance over which it occurs\n"
          "(10 % to 90 %), mm; largest rise with noise, mm.",
          {{"step_p05_mm", "rise p5", kMm, [](const Row& r) { return step_mm(r.clean_step, &Spread::p05); }},
           {"step_p50_mm", "p50", kMm, [](const Row& r) { return step_mm(r.clean_step, &Spread::p50); }},
           {"step_p95_mm", "p95", kMm, [](const Row& r) { return step_mm(r.clean_step, &Spread::p95); }},
           {"step_over_p50_mm", "over", kMm,
            [](const Row& r) { return r.clean_step ? kToMm * r.clean_step->rise_over.p50 : kNone; }},
           {"noisy_step_p05_mm", "noisy p5", kMm, [](const Row& r) { return step_mm(r.step, &Spread::p05); }},
           {"noisy_step_p50_mm", "p50", kMm, [](const Row& r) { return step_mm(r.step, &Spread::p50); }},
           {"noisy_step_p95_mm", "p95", kMm, [](const Row& r) { return step_mm(r.step, &Spread::p95); }}}};
}

Section edged() {
  return {
      "Crossing of an edge of 90 degrees",
      "Largest deviation of the proxy from the path of a rolling ball, mm, and its position along the path\n"
      "of the ball's centre, from the middle of its turn, mm.",
      {{"edge_off_p50_mm", "deviation p50", kMm,
        [](const Row& r) { return r.edge ? kToMm * r.edge->off.p50 : kNone; }},
       {"edge_off_p95_mm", "p95", kMm, [](const Row& r) { return r.edge ? kToMm * r.edge->off.p95 : kNone; }},
       {"edge_off_max_mm", "max", kMm, [](const Row& r) { return r.edge ? kToMm * r.edge->off.max : kNone; }},
       {"edge_where_mm", "position", kMm,
        [](const Row& r) { return r.edge ? kToMm * r.edge->where : kNone; }}}};
}

Section timed() {
  return {"Computation time per tick",
          "Contacts and force, in contact, us.",
          {{"tick_p50_us", "p50", kUs, [](const Row& r) { return r.figures.tick.p50; }},
           {"tick_p99_us", "p99", kUs, [](const Row& r) { return r.figures.tick.p99; }},
           {"tick_p99.9_us", "p99.9", kUs, [](const Row& r) { return r.figures.tick.p999; }}}};
}

/// Width of a column of the printed table, in characters.
/// [[at, p05, p50, p95], ...]
OrderedJson curve_json(const Curve& curve) {
  OrderedJson json = OrderedJson::array();
  for (const CurvePoint& p : curve) json.push_back({p.at, p.value.p05, p.value.p50, p.value.p95});
  return json;
}

OrderedJson curves_json(const Row& row) {
  OrderedJson slide = OrderedJson::array();
  for (const Eigen::Vector2d& p : row.figures.slide) slide.push_back({p.x(), p.y()});
  OrderedJson json{{"direction_deg", curve_json(row.figures.direction_at)},
                   {"force_n", curve_json(row.figures.force_at)},
                   {"slide_n", std::move(slide)}};
  if (!row.friction_at.empty()) json["friction"] = curve_json(row.friction_at);
  if (row.step) json["noisy_step_m"] = curve_json(row.step->path);
  if (row.clean_step) json["step_m"] = curve_json(row.clean_step->path);
  if (row.edge) json["edge_m"] = curve_json(row.edge->error);
  return json;
}

}  // namespace

bool EvaluationSection::has(const EvaluationRow& row) const {
  return std::any_of(columns.begin(), columns.end(),
                     [&](const Column& c) { return !std::isnan(c.value(row)); });
}

const std::vector<EvaluationSection>& evaluation_sections() {
  static const std::vector<Section> all{pressed(), seen(),    moved(), rubbed(),
                                        denser(),  stepped(), edged(), timed()};
  return all;
}

std::string evaluation_text(const std::vector<EvaluationRow>& rows) {
  std::string text;
  bool first = true;
  for (const Section& section : evaluation_sections()) {
    if (std::none_of(rows.begin(), rows.end(), [&](const Row& r) { return section.has(r); })) continue;
    text += fmt::format("{}{}\n{}\n\n", first ? "" : "\n", section.title, section.note);
    first = false;
    text += fmt::format("{:<9} {:>7} {:<8}", "shape", "spacing", "model");
    for (const Column& c : section.columns)
      text += fmt::format(" {:>{}}", c.heading, width_of(c, kNarrowestColumn));
    text += '\n';
    for (const Row& row : rows) {
      if (!section.has(row)) continue;
      text += fmt::format("{:<9} {:>4.1f} mm {:<8}", row.shape, kToMm * row.spacing, row.model);
      for (const Column& c : section.columns)
        text += fmt::format(" {:>{}}", text_of(c, row), width_of(c, kNarrowestColumn));
      text += '\n';
    }
  }
  return text;
}

OrderedJson evaluation_json(const std::vector<EvaluationRow>& rows) {
  OrderedJson json = OrderedJson::array();
  for (const Row& row : rows) {
    OrderedJson one{{"shape", row.shape}, {"spacing_m", row.spacing}, {"model", row.model}};
    for (const Section& section : evaluation_sections()) put_figures(section.columns, row, one);
    one["curves"] = curves_json(row);
    json.push_back(std::move(one));
  }
  return json;
}

std::string evaluation_csv(const std::vector<EvaluationRow>& rows) {
  std::string text = "shape,spacing_m,model";
  for (const Section& section : evaluation_sections()) text += csv_names(section.columns);
  text += '\n';
  for (const Row& row : rows) {
    text += fmt::format("{},{},{}", row.shape, row.spacing, row.model);
    for (const Section& section : evaluation_sections()) text += csv_figures(section.columns, row);
    text += '\n';
  }
  return text;
}

EvaluationRow evaluation_row(const EvaluationSetup& setup, const std::string& model,
                             const Progress& progress) {
  EvaluationRow row{setup.shape, model, *setup.scene.spacing, evaluate(setup, progress)};
  if (setup.friction > 0.0) row.friction_at = friction_response(setup, {0.1, 0.2, 0.3, 0.5, 0.8});
  if (setup.shape == "box") row.edge = edge_response(setup);
  if (setup.shape != "step") return row;
  row.step = step_response(setup);
  EvaluationSetup clean = setup;
  clean.scene.noise = clean.scene.tilt = 0.0;
  row.clean_step = step_response(clean);
  return row;
}

void compare_densities(std::vector<EvaluationRow>& rows, double first_spacing) {
  for (EvaluationRow& row : rows) {
    if (row.spacing == first_spacing) continue;
    for (const EvaluationRow& first : rows) {
      if (first.shape == row.shape && first.model == row.model && first.spacing == first_spacing)
        row.denser = force_ratio(row.figures, first.figures);
    }
  }
}

}  // namespace palpate
