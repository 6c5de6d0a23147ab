#include <palpate/report/columns_page.h>

#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <palpate/record/run_columns.h>
#include <palpate/report/capture_report.h>
#include <palpate/report/evaluation_table.h>

namespace palpate {
namespace {

/// A column or a field; `name` may stand for all below it.
struct Named {
  std::string_view name, unit, help;
};
using Names = std::vector<Named>;

const Names kTrajectory{
    {"t", "s", "time; increases"},
    {"x", "m", "tool centre, world"},
    {"y", "m", "likewise"},
    {"z", "m", "likewise"},
    {"qw", "1", "orientation of the tool, world; all four may be left out: upright"},
    {"qx", "1", "likewise"},
    {"qy", "1", "likewise"},
    {"qz", "1", "likewise"},
};

const Names kMade{
    {"version", "", "of the program"},
    {"command", "", "that made it"},
    {"scene", "", "name of the scene's file, or of the built-in scene"},
    {"scene_checksum", "", "xxh3-16MiB: XXH3 over the XXH3 of every 16 MiB of the file"},
    {"materials_checksum", "", "the same of --materials; only with that"},
    {"device", "", "of a live loop: its name, and its kind"},
    {"machine", "", "processor, cores, compiler, date (UTC)"},
    {"settings", "", "object: options of the command by their long names, as --help describes them"},
};

const Names kInfo{
    {"file", "", "as it was given"},
    {"format", "", "that the file was taken for"},
    {"gaussians", "1", "in the file"},
    {"sh_degree", "1", "of the spherical harmonics"},
    {"trailing_bytes", "byte", "behind the data"},
    {"bounds", "captured", "box of the centres: min, max"},
    {"robust_bounds", "captured", "of the central 98 % of each coordinate"},
    {"opacity", "1", "quantiles, by their share"},
    {"longest_sigma", "captured", "likewise"},
    {"shortest_sigma", "captured", "likewise"},
    {"lint", "1", "findings: how many of each"},
    {"filter.opacity_min", "1", "--opacity-min"},
    {"filter.kept", "1", "Gaussians that can be touched"},
    {"filter.share", "1", "of all"},
    {"filter.defective", "1", "left out: they cannot collide"},
    {"filter.low_opacity", "1", "left out by --opacity-min"},
    {"filter.below_iso", "1", "by --iso"},
    {"filter.over_max_scale", "1", "by --max-scale"},
    {"filter.outside_crop", "1", "by the crop"},
    {"kept_share", "1", "of all, above each of the paper's thresholds of opacity"},
    {"frame", "", "what is assumed about the captured frame"},
    {"world_bounds", "m", "box of the kept ellipsoids, world: min, max"},
    {"proposed", "", "what setup proposes; null where nothing can be touched"},
    {"made", "", "see above"},
};

const Names kSetup{
    {"frame", "", "--frame: value, and the reason"},
    {"scale", "m/unit", "--scale, likewise"},
    {"opacity_min", "1", "--opacity-min, likewise"},
    {"max_scale", "m", "--max-scale, likewise; value null: none"},
    {"crop_box", "m", "--crop-box, likewise"},
    {"made", "", "see above"},
};

const Names kQuery{
    {"candidates", "1", "Gaussians after the broad phase"},
    {"filtered", "1", "of them, those whose bounding spheres meet"},
    {"contacts[].id", "1", "row of the Gaussian in the scene file"},
    {"contacts[].k_min", "1", "K_min (paper eq. 6): 0 just touching, 1 centres coincide"},
    {"contacts[].lambda", "1", "where K is least"},
    {"contacts[].opacity", "1", "of the Gaussian"},
    {"contacts[].center", "m", "of the Gaussian, world"},
    {"contacts[].point", "m", "of contact, world"},
    {"contacts[].normal", "1", "outward, world"},
    {"contacts[].depth", "m", "of the overlap, along the normal"},
    {"contacts[].part", "", "of the tool, its name"},
    {"contacts[].confidence", "1", "that there is a surface, 0 to 1; null with --pipeline paper"},
    {"force", "N", "on the tool, world"},
    {"torque", "N m", "about the tool centre, world"},
    {"confidence", "1", "of the force"},
    {"made", "", "see above"},
};

const Names kReplay{
    {"poses", "1", "of the trajectory"},
    {"seconds", "s", "from the first to the last"},
    {"contact_poses", "1", "that touch something"},
    {"episodes", "1", "stretches of contact"},
    {"colliding_max", "1", "most contacts of a pose"},
    {"force_max", "N", "largest force"},
    {"compute_us", "us", "of a pose: p50, p99, max"},
    {"made", "", "see above"},
};

const Names kRun{
    {"ticks", "1", "of the loop"},
    {"rate_hz", "Hz", "ticks over seconds"},
    {"overruns", "1", "ticks that were due while another took too long, and left out"},
    {"tick_us", "us", "of a tick: p50, p99, p999, max"},
    {"cpu_us", "us", "of it computing, likewise"},
    {"age_us", "us", "of the force when it was sent, likewise"},
    {"late_us", "us", "how late ticks began, likewise"},
    {"contact_ticks", "1", "that touch something"},
    {"contacts_max", "1", "most contacts of a tick"},
    {"force_max", "N", "largest force that was sent"},
    {"port_energy", "J", "put out at most more than was taken in"},
    {"margin_min", "1", "least margin of the stiffness; 0: none is known"},
    {"state", "word", "of the governor, before the end"},
    {"faults", "word", "that there were, once each"},
    {"made", "", "see above"},
    {"hands", "", "with --hands: of each other hand, under its name, the same"},
};

const Names kBench{
    {"machine", "", "processor, cores, compiler, date"},
    {"scene", "", "file"},
    {"scene_bytes", "byte", "its size"},
    {"gaussians", "1", "that can be touched"},
    {"pipeline", "", "exact or paper"},
    {"simd", "", "instruction set"},
    {"model", "", "force model"},
    {"tool", "m", "its parts: name, semi-axes, position, orientation"},
    {"open.seconds", "s", "from a file to a query"},
    {"open.origin", "", "of the index: index file, new index file or memory"},
    {"open.remarks", "", "why an index file was not used or not written"},
    {"open.index_bytes", "byte", "of the index; null if unknown"},
    {"open.bytes_per_gaussian", "byte", "likewise"},
    {"open.peak_rss_bytes", "byte", "largest resident set so far"},
    {"path", "", "file of the trajectory; null: made here"},
    {"poses", "1", "of the trajectory"},
    {"contact_poses", "1", "that touch something"},
    {"rounds", "1", "the least time of each pose counts"},
    {"latency_us.query_contact", "us",
     "fresh query, in contact: count, p50, p99, p99.9, max; null: no such pose"},
    {"latency_us.query_free", "us", "without contact, likewise"},
    {"latency_us.tracker_contact", "us", "tracker, in contact, likewise"},
    {"latency_us.force_contact", "us", "force model, in contact, likewise"},
    {"sizes", "1", "contacts, filtered and candidates of poses in contact: median, max; null: none"},
    {"throughput.threads", "1", "that queried at once"},
    {"throughput.queries_per_second", "1/s", "of all of them"},
    {"throughput.in_contact", "", "whether of poses in contact, or of all"},
    {"made", "", "see above"},
};

const Names kEvaluateRow{
    {"shape", "", "surface that is felt"},
    {"spacing_m", "m", "mean distance of neighbours"},
    {"model", "", "force model"},
};

const Names kTrialRow{
    {"tool", "", "its name"},
    {"place", "", "where it is pushed at"},
    {"like", "", "what the capture is like"},
    {"strokes", "1", "that were pushed"},
    {"slow", "1", "of them, at up to 0.5 m/s"},
    {"silent", "1", "in which nothing is felt deep inside"},
    {"sunk", "1", "in which the proxy sinks in"},
    {"through", "1", "in which it comes out behind"},
    {"stuck", "1", "at whose end a force is left"},
    {"onsets", "1", "slow ones from outside that meet the seen surface; where force begins is of these"},
    {"onset_p05_mm", "mm", "where it begins, from the seen surface: 5 of 100 begin before"},
    {"onset_p50_mm", "mm", "median"},
    {"onset_p95_mm", "mm", "95 of 100"},
    {"true_p50_mm", "mm", "where it begins, from the true surface, median"},
    {"true_p95_mm", "mm", "95 of 100"},
    {"late_p05_mm", "mm", "how late it begins, from the seen surface or the first ellipsoid: 5 of 100"},
    {"late_p50_mm", "mm", "median"},
    {"late_p95_mm", "mm", "95 of 100"},
    {"within_half_mm_percent", "%", "late by 0.5 mm at most"},
    {"within_1mm_percent", "%", "by 1 mm"},
    {"magnitude_p05", "1", "|F| over stiffness times depth: 5 of 100"},
    {"magnitude_p50", "1", "median"},
    {"magnitude_p95", "1", "95 of 100"},
    {"step_max_n", "N",
     "largest change of the force in a tick, beyond stiffness times the motion of the tool"},
    {"tick_p50_us", "us", "time of a tick, median"},
    {"tick_p99.9_us", "us", "999 of 1000"},
    {"tick_max_us", "us", "the longest"},
    {"first_silent", "1", "first stroke that was silent, for --stroke; none: nothing"},
    {"first_sunk", "1", "likewise"},
    {"first_through", "1", "likewise"},
    {"first_stuck", "1", "likewise"},
    {"first_late", "1", "likewise"},
};

const Names kTrialLists{
    {"silent_strokes", "1", "numbers of those strokes"},
    {"sunk_strokes", "1", "likewise"},
    {"through_strokes", "1", "likewise"},
    {"stuck_strokes", "1", "likewise"},
    {"late_strokes", "1", "likewise"},
};

const Names kStroke{
    {"made", "", "see above"},
    {"tool", "", "its name"},
    {"place", "", "where it is pushed at"},
    {"like", "", "what the capture is like"},
    {"stroke", "1", "its number"},
    {"speed", "m/s", "of the push"},
    {"seen", "m", "way to the seen surface; null: never"},
    {"touched", "m", "to the first ellipsoid; null: never"},
    {"felt", "m", "to the first force; null: never"},
    {"late", "m", "how late that is; null: it is not known"},
    {"silent", "", "whether nothing is felt deep inside"},
    {"sunk", "", "whether the proxy sinks in"},
    {"through", "", "whether it comes out behind"},
    {"stuck", "", "whether a force is left at the end"},
    {"step", "N", "largest change of the force in a tick, beyond stiffness times the motion of the tool"},
};

const Names kStrokeTicks{
    {"t", "s", "time"},
    {"x", "m", "tool centre, world"},
    {"y", "m", "likewise"},
    {"z", "m", "likewise"},
    {"proxy_x", "m", "proxy, world"},
    {"proxy_y", "m", "likewise"},
    {"proxy_z", "m", "likewise"},
    {"fx", "N", "force on the tool, world"},
    {"fy", "N", "likewise"},
    {"fz", "N", "likewise"},
    {"depth_m", "m", "of the tool in the true surface"},
    {"proxy_depth_m", "m", "of the proxy"},
    {"confidence", "1", "that there is a surface"},
};

const Names kStabilityCsv{
    {"profile", "", "device"},
    {"hand_mass", "kg", "of the hand that holds it"},
    {"hand_damping", "N s/m", "likewise"},
    {"hand_stiffness", "N/m", "likewise"},
    {"model", "", "force model"},
    {"contacts", "", "who looks for them: loop, worker, or hold"},
    {"delay_ms", "ms", "of worker and hold"},
    {"limit_cycle_mm", "mm", "swing at rest, peak to peak"},
    {"port_energy_mj", "mJ", "put out at most more than was taken in"},
    {"contact_changes", "1", "how often force began or ended"},
    {"rest_force_n", "N", "at rest, the least of all places"},
    {"slide_force_off", "1", "how far the force is from that of the loop while sliding, in 95 of 100 ticks"},
    {"fault", "word", "why force was held back"},
    {"z_width_n_m", "N/m", "stiffest that can be held; nothing for density"},
};

const Names kStability{
    {"made", "", "see above"},
    {"rows[].profile", "", "device"},
    {"rows[].hand", "kg, N s/m, N/m", "that holds it; null: an ideal wall"},
    {"rows[].model", "", "force model, or wall"},
    {"rows[].hold_ms", "ms", "how late a force is that is held"},
    {"rows[].worker_ms", "ms", "how late a worker is"},
    {"rows[].limit_cycle_mm", "mm", "swing at rest, peak to peak"},
    {"rows[].port_energy_mj", "mJ", "put out at most more than was taken in"},
    {"rows[].contact_changes", "1", "how often force began or ended"},
    {"rows[].rest_force", "N", "at rest, the least of all places"},
    {"rows[].slide_force_off", "1", "how far the force is from that of the loop while sliding"},
    {"rows[].fault", "word", "why force was held back"},
    {"rows[].z_width", "N/m", "stiffest that can be held; null for density"},
    {"rows[].passivity", "", "of a wall: with the passivity controller"},
    {"rows[].z_width_bound", "N/m", "of a wall: in theory"},
};

const Names kReproduceCsv{
    {"run", "", "force model of the run"},
    {"t", "s", "time"},
    {"x", "m", "tool centre, world"},
    {"y", "m", "likewise"},
    {"z", "m", "likewise"},
    {"candidates", "1", "Gaussians after the broad phase"},
    {"filtered", "1", "of them, those whose bounding spheres meet"},
    {"colliding", "1", "of them, those that overlap the tool"},
    {"fx", "N", "force on the tool, world"},
    {"fy", "N", "likewise"},
    {"fz", "N", "likewise"},
    {"ufx", "N", "force of the user, world"},
    {"ufy", "N", "likewise"},
    {"ufz", "N", "likewise"},
    {"cpu_us", "us", "of the processor, for contacts and force"},
    {"wall_us", "us", "of the clock, likewise"},
    {"true_depth", "m", "of the tool in the true surface; nothing where nobody knows that"},
};

const Names kReproduce{
    {"setup", "", "what was done, in a few sentences"},
    {"claims[].paper", "", "statement of the paper"},
    {"claims[].figure", "", "its figure"},
    {"claims[].measured", "", "what was measured"},
    {"claims[].bound", "", "where it is true"},
    {"claims[].paper_pipeline", "as measured", "with the paper's pipeline and force; null: not known"},
    {"claims[].default", "as measured", "with the project's defaults; null: not known"},
    {"claims[].met", "", "whether the default meets the bound; null: not known"},
    {"claims[].ratio", "1", "how many times as good as that; null: not known"},
    {"runs[].model", "", "force model"},
    {"runs[].device", "", "admittance or impedance"},
    {"runs[].held_ms", "ms", "how long a force is held"},
    {"runs[].port_energy_mj", "mJ", "put out at most more than was taken in"},
    {"runs[].held_ticks", "1", "in which a limit of the device held its motion"},
    {"runs[].faults", "word", "that there were, once each"},
    {"runs[].contacts[].begins", "s", "time; null: never"},
    {"runs[].contacts[].colliding", "1", "Gaussians at once, the most"},
    {"runs[].contacts[].force", "N", "at rest"},
    {"runs[].contacts[].user_force", "N", "at rest"},
    {"runs[].contacts[].direction", "1", "of the force, world"},
    {"runs[].contacts[].swing_mm", "mm", "at rest, peak to peak about the line that it goes"},
    {"runs[].contacts[].overshoot_mm", "mm", "of the deepest over the place of rest"},
    {"runs[].contacts[].bounces", "1", "how often the force ended before that on the way back out"},
    {"runs[].contacts[].true_depth_mm", "mm", "at rest; null: nobody knows the surface"},
    {"runs[].contacts[].off_deg", "deg", "of the force from the true normal; null: likewise"},
    {"made", "", "see above"},
};

std::string_view presence(const RunColumn& column) {
  switch (column.group) {
    case ColumnGroup::kUserForce: return "where the handle measures force";
    case ColumnGroup::kLive: return column.may_lack ? "live; not in the first recordings" : "live";
    default: return "always";
  }
}

/// The page, as it grows.
class Page {
 public:
  void all() {
    print(
        "# Columns and fields\n\nEvery column of a CSV and every field of `--json`. This page is what "
        "`palpate "
        "columns` prints; a test "
        "holds it against what the commands write.\n\nNumbers are in SI units unless a name says otherwise, "
        "and read back exactly. A "
        "CSV begins with lines of a comment, each after `#`: TOML that says how it was made, the tables "
        "`[made]` and `[settings]`; then "
        "comes the line of names. In JSON that is the object `made`. `[]` stands for each item of an array; "
        "an "
        "object without fields "
        "of its own here is told as a whole.\n");
    table("Trajectories",
          "What `palpate make-path` and `evaluate --worst` write, and `--trajectory` reads; columns in any "
          "order, further ones "
          "ignored.",
          "column", kTrajectory);
    runs();
    table("`made`", "How a result was made; in the `[made]` of a CSV the names have `-` for `_`.", "field",
          kMade);
    table("`palpate info --json`", "A scene.", "field", kInfo);
    table("`palpate setup --json`", "Proposals, each an object of `value` and `reason`; and `made`.", "field",
          kSetup);
    table("`palpate query --json`", "One pose.", "field", kQuery);
    table("`palpate replay --json`", "A summary of the run.", "field", kReplay);
    table("`palpate run --json`", "A summary of the live loop.", "field", kRun);
    table("`palpate bench --json`", "Times of queries.", "field", kBench);
    evaluate();
    capture();
    trials();
    table("`palpate stability`", "`--csv`, a row a device, hand, model and source of contacts.", "column",
          kStabilityCsv);
    table("`palpate stability --json`", "The same, and ideal walls.", "field", kStability);
    table("`palpate reproduce`", "`--csv`, a row a tick of the first two runs.", "column", kReproduceCsv);
    table("`palpate reproduce --json`", "Claims and runs.", "field", kReproduce);
  }

  std::string text() && { return std::move(text_); }

 private:
  template <typename... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  void rows(std::string_view prefix, const Names& names) {
    for (const Named& named : names)
      print("| `{}{}` | {} | {} |\n", prefix, named.name, named.unit, named.help);
  }

  void begin(std::string_view title, std::string_view note, std::string_view what) {
    print("\n## {}\n\n{}\n\n| {} | unit | what |\n|---|---|---|\n", title, note, what);
  }

  void table(std::string_view title, std::string_view note, std::string_view what, const Names& names) {
    begin(title, note, what);
    rows("", names);
  }

  void runs() {
    print(
        "\n## Runs\n\nOf `palpate replay` and of recordings, a row a pose or tick. `live`: of a live "
        "loop.\n\n| column | unit | there "
        "| what |\n|---|---|---|---|\n");
    for (const RunColumn& column : run_columns())
      print("| `{}` | {} | {} | {} |\n", column.name, column.unit, presence(column), column.help);
    for (const RunColumn& column : run_columns()) {
      if (column.words.empty()) continue;
      print("\n`{}` is one of", column.name);
      for (const std::string_view word : column.words) print(" `{}`", word);
      print("; recordings of earlier versions have its number, from 0.\n");
    }
  }

  /// Of a table for people, whose note says what its columns are.
  void section_rows(std::string_view prefix, const EvaluationSection& section) {
    for (const EvaluationColumn& column : section.columns)
      print("| `{}{}` | by its name | {}: {} |\n", prefix, column.name, section.title, column.heading);
  }

  void evaluate() {
    begin(
        "`palpate evaluate`",
        "`--csv`, a row a shape, spacing and model. The tables that the command prints say what is measured.",
        "column");
    rows("", kEvaluateRow);
    for (const EvaluationSection& section : evaluation_sections()) section_rows("", section);
    begin("`palpate evaluate --json`", "The same.", "field");
    rows("", {{"made", "", "see above"}});
    rows("rows[].", kEvaluateRow);
    for (const EvaluationSection& section : evaluation_sections()) section_rows("rows[].", section);
    rows("rows[].",
         {{"curves", "by its name", "what was measured along a way: at, then 5, 50 and 95 of 100"}});
  }

  void capture() {
    const auto columns = [this](std::string_view prefix) {
      print("| `{}model` |  | force model |\n", prefix);
      for (const auto& column : capture_columns())
        print("| `{}{}` | by its name | {} |\n", prefix, column.name, column.heading);
    };
    begin("`palpate evaluate --scene`", "`--csv`, a row a model.", "column");
    columns("");
    begin("`palpate evaluate --scene --json`", "The same.", "field");
    rows("", {{"made", "", "see above"}});
    columns("rows[].");
  }

  void trials() {
    table("`palpate evaluate --trials`", "`--csv`, a row a tool, place and kind of capture.", "column",
          kTrialRow);
    begin("`palpate evaluate --trials --json`", "The same.", "field");
    rows("", {{"made", "", "see above"}});
    rows("rows[].", kTrialRow);
    rows("rows[].", kTrialLists);
    table("`palpate evaluate --trials --stroke`", "`--csv`, a row a tick of one stroke.", "column",
          kStrokeTicks);
    table("`palpate evaluate --trials --stroke --json`", "The stroke.", "field", kStroke);
  }

  std::string text_;
};

}  // namespace

std::string columns_page() {
  Page page;
  page.all();
  return std::move(page).text();
}

}  // namespace palpate
