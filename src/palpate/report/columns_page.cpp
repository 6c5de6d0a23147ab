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

/// A column or a field; the `name` of an object may stand for all its fields.
struct Named {
  std::string_view name, unit, help;
};
using Names = std::vector<Named>;

const Names kTrajectory{
    {"t", "s", "time, increasing"},
    {"x", "m", "position of the tool centre, x component, world frame"},
    {"y", "m", "position of the tool centre, y component, world frame"},
    {"z", "m", "position of the tool centre, z component, world frame"},
    {"qw", "1",
     "orientation of the tool, quaternion, w component, world frame; qw to qz are optional (default: "
     "upright)"},
    {"qx", "1", "orientation of the tool, quaternion, x component, world frame"},
    {"qy", "1", "orientation of the tool, quaternion, y component, world frame"},
    {"qz", "1", "orientation of the tool, quaternion, z component, world frame"},
};

const Names kMade{
    {"version", "", "version of the program"},
    {"command", "", "command that produced the result"},
    {"scene", "", "name of the scene file or of the built-in scene"},
    {"scene_checksum", "", "checksum of the scene file; xxh3-16MiB: XXH3 over the XXH3 of every 16 MiB"},
    {"materials_checksum", "", "checksum of the --materials file, in the same format; only with --materials"},
    {"device", "", "name and kind of the device; only for a live loop"},
    {"machine", "", "processor, cores, compiler, date (UTC)"},
    {"settings", "", "object: command options by long name, as in --help"},
};

const Names kInfo{
    {"file", "", "file name as given"},
    {"format", "", "detected file format"},
    {"gaussians", "1", "number of Gaussians in the file"},
    {"sh_degree", "1", "degree of the spherical harmonics"},
    {"trailing_bytes", "byte", "unexplained bytes after the data"},
    {"bounds", "captured", "bounding box of the centres: min, max"},
    {"robust_bounds", "captured", "bounding box of the central 98 % of each coordinate: min, max"},
    {"opacity", "1", "quantiles of the opacity, keyed by fraction"},
    {"longest_sigma", "captured", "quantiles of the longest standard deviation"},
    {"shortest_sigma", "captured", "quantiles of the shortest standard deviation"},
    {"lint", "1", "number of lint findings of each kind"},
    {"filter.opacity_min", "1", "value of --opacity-min"},
    {"filter.kept", "1", "Gaussians that the filter keeps"},
    {"filter.share", "1", "kept fraction of all Gaussians"},
    {"filter.defective", "1", "Gaussians dropped as defective: they cannot collide"},
    {"filter.low_opacity", "1", "Gaussians dropped by --opacity-min"},
    {"filter.below_iso", "1", "Gaussians dropped by --iso"},
    {"filter.over_max_scale", "1", "Gaussians dropped by --max-scale"},
    {"filter.outside_crop", "1", "Gaussians dropped by --crop-box or --crop-sphere"},
    {"kept_share", "1", "fraction of all Gaussians above each opacity threshold of the paper"},
    {"frame", "", "assumptions about the captured frame"},
    {"world_bounds", "m", "bounding box of the kept ellipsoids, world frame: min, max"},
    {"proposed", "", "proposals of palpate setup; null if the filter keeps nothing"},
    {"made", "", "provenance (see `made`)"},
};

const Names kSetup{
    {"frame", "", "--frame: value and reason"},
    {"scale", "m/unit", "--scale: value and reason"},
    {"opacity_min", "1", "--opacity-min: value and reason"},
    {"max_scale", "m", "--max-scale: value (null = no limit) and reason"},
    {"crop_box", "m", "--crop-box: value (null = no crop) and reason"},
    {"made", "", "provenance (see `made`)"},
};

const Names kQuery{
    {"candidates", "1", "Gaussians after the broad phase"},
    {"filtered", "1", "candidates after the bounding-sphere test"},
    {"contacts[].id", "1", "row of the Gaussian in the scene file"},
    {"contacts[].k_min", "1", "K_min (paper eq. 6): 0 = just touching, 1 = coincident centres"},
    {"contacts[].lambda", "1", "lambda at which K is minimal"},
    {"contacts[].opacity", "1", "opacity of the Gaussian"},
    {"contacts[].center", "m", "centre of the Gaussian, world frame"},
    {"contacts[].point", "m", "contact point, world frame"},
    {"contacts[].normal", "1", "outward contact normal, world frame"},
    {"contacts[].depth", "m", "penetration depth along the normal"},
    {"contacts[].part", "", "name of the tool part in contact"},
    {"contacts[].confidence", "1", "confidence that a surface exists, in [0, 1]; null with --pipeline paper"},
    {"force", "N",
     "force on the tool, world frame, after it has rested at the pose until the force settled, 0.3 s at "
     "most"},
    {"torque", "N m", "torque about the tool centre, world frame, at the same time"},
    {"confidence", "1", "confidence of the force"},
    {"made", "", "provenance (see `made`)"},
    {"search_radius", "m", "with --pipeline paper: search radius of the kd-tree"},
    {"can_miss", "1",
     "with --pipeline paper: Gaussians that reach beyond the search radius and may be missed"},
};

const Names kReplay{
    {"poses", "1", "number of poses in the trajectory"},
    {"seconds", "s", "time from the first pose to the last"},
    {"contact_poses", "1", "poses in contact"},
    {"episodes", "1", "contact episodes"},
    {"colliding_max", "1", "largest number of contacts at a pose"},
    {"force_max", "N", "largest force"},
    {"compute_us", "us", "computation time of a pose: p50, p99, max"},
    {"made", "", "provenance (see `made`)"},
    {"search_radius", "m", "with --pipeline paper: search radius of the kd-tree"},
    {"can_miss", "1",
     "with --pipeline paper: Gaussians that reach beyond the search radius and may be missed"},
};

const Names kRun{
    {"ticks", "1", "number of ticks of the loop"},
    {"rate_hz", "Hz", "mean rate: ticks over elapsed time"},
    {"overruns", "1", "ticks skipped because an earlier tick took too long"},
    {"tick_us", "us", "duration of a tick: p50, p99, p999, max"},
    {"cpu_us", "us", "processor time of a tick: p50, p99, p999, max"},
    {"age_us", "us", "age of the device reading when the force is sent: p50, p99, p999, max"},
    {"late_us", "us", "delay of the start of a tick: p50, p99, p999, max"},
    {"contact_ticks", "1", "ticks in contact"},
    {"contacts_max", "1", "largest number of contacts in a tick"},
    {"force_max", "N", "largest force sent to the device"},
    {"port_energy", "J", "net energy output at the device port"},
    {"margin_min", "1", "smallest stiffness margin; 0 if unknown"},
    {"state", "word", "state of the governor before shutdown"},
    {"faults", "word", "faults that occurred, once each"},
    {"lost", "1", "with --record: ticks that the recording lacks; else 0"},
    {"made", "", "provenance (see `made`)"},
    {"hands", "", "with --hands: the same fields for each other hand, keyed by its name"},
};

const Names kBench{
    {"machine", "", "processor, cores, compiler, date"},
    {"scene", "", "scene file"},
    {"scene_bytes", "byte", "size of the scene file"},
    {"gaussians", "1", "Gaussians that can be touched"},
    {"pipeline", "", "exact or paper"},
    {"simd", "", "instruction set"},
    {"model", "", "force model"},
    {"tool", "m", "tool parts: name, semi-axes, position, orientation"},
    {"open.seconds", "s", "time to open the scene file for queries"},
    {"open.origin", "", "origin of the index: index file, new index file or memory"},
    {"open.remarks", "", "reasons why an index file was not used or not written"},
    {"open.index_bytes", "byte", "size of the index; null if unknown"},
    {"open.bytes_per_gaussian", "byte", "size of the index per Gaussian; null if unknown"},
    {"open.peak_rss_bytes", "byte", "peak resident set size after opening"},
    {"path", "", "trajectory file; null if the path is generated"},
    {"poses", "1", "number of poses in the trajectory"},
    {"contact_poses", "1", "poses in contact"},
    {"rounds", "1", "repetitions of the path; the minimum time per pose is used"},
    {"latency_us.query_contact", "us",
     "fresh query in contact: count, p50, p99, p99.9, max; null if there is no such pose"},
    {"latency_us.query_free", "us", "fresh query without contact: the same statistics"},
    {"latency_us.tracker_contact", "us", "contact tracker in contact: the same statistics"},
    {"latency_us.force_contact", "us", "force model in contact: the same statistics"},
    {"sizes", "1",
     "contacts, filtered and candidates of poses in contact: median, max; null if there are none"},
    {"throughput.threads", "1", "number of query threads"},
    {"throughput.queries_per_second", "1/s", "queries per second of all threads together"},
    {"throughput.in_contact", "", "true if measured at poses in contact, false if at all poses"},
    {"made", "", "provenance (see `made`)"},
};

const Names kEvaluateRow{
    {"shape", "", "shape of the surface"},
    {"spacing_m", "m", "mean distance between neighbouring Gaussians"},
    {"model", "", "force model"},
};

const Names kTrialRow{
    {"tool", "", "name of the tool"},
    {"place", "", "place that the tool is pushed at (--trial-places)"},
    {"like", "", "capture defect of the scene (--like)"},
    {"strokes", "1", "number of strokes"},
    {"slow", "1", "strokes at up to 0.5 m/s"},
    {"silent", "1", "strokes with less than a tenth of stiffness times depth deep inside"},
    {"sunk", "1", "strokes in which the proxy sinks into the surface"},
    {"through", "1", "strokes in which the proxy passes through to the far side"},
    {"stuck", "1", "strokes that end with a residual force"},
    {"onsets", "1",
     "slow strokes from outside that reach the visible surface; basis of the onset and delay figures"},
    {"onset_p05_mm", "mm", "force onset relative to the visible surface, negative before it, 5th percentile"},
    {"onset_p50_mm", "mm", "force onset relative to the visible surface, median"},
    {"onset_p95_mm", "mm", "force onset relative to the visible surface, 95th percentile"},
    {"true_p50_mm", "mm", "force onset relative to the true surface, median"},
    {"true_p95_mm", "mm", "force onset relative to the true surface, 95th percentile"},
    {"late_p05_mm", "mm",
     "onset delay from the visible surface or the first ellipsoid, whichever is later, 5th percentile"},
    {"late_p50_mm", "mm", "onset delay, median"},
    {"late_p95_mm", "mm", "onset delay, 95th percentile"},
    {"within_half_mm_percent", "%", "share of onsets delayed by at most 0.5 mm"},
    {"within_1mm_percent", "%", "share of onsets delayed by at most 1 mm"},
    {"magnitude_p05", "1", "force over stiffness times depth, 5th percentile"},
    {"magnitude_p50", "1", "force over stiffness times depth, median"},
    {"magnitude_p95", "1", "force over stiffness times depth, 95th percentile"},
    {"step_max_n", "N", "largest force change in a tick beyond stiffness times the tool motion"},
    {"tick_p50_us", "us", "computation time of a tick, median"},
    {"tick_p99.9_us", "us", "computation time of a tick, 99.9th percentile"},
    {"tick_max_us", "us", "computation time of a tick, maximum"},
    {"first_silent", "1", "number of the first silent stroke, for --stroke; empty or null if there is none"},
    {"first_sunk", "1", "number of the first stroke in which the proxy sinks in"},
    {"first_through", "1", "number of the first stroke in which the proxy passes through"},
    {"first_stuck", "1", "number of the first stroke with a residual force"},
    {"first_late", "1", "number of the first stroke with a late or missing onset"},
};

const Names kTrialLists{
    {"silent_strokes", "1", "numbers of the silent strokes"},
    {"sunk_strokes", "1", "numbers of the strokes in which the proxy sinks in"},
    {"through_strokes", "1", "numbers of the strokes in which the proxy passes through"},
    {"stuck_strokes", "1", "numbers of the strokes with a residual force"},
    {"late_strokes", "1", "numbers of the strokes with a late (by more than 1 mm) or missing onset"},
};

const Names kStroke{
    {"made", "", "provenance (see `made`)"},
    {"tool", "", "name of the tool"},
    {"place", "", "place that the tool is pushed at (--trial-places)"},
    {"like", "", "capture defect of the scene (--like)"},
    {"stroke", "1", "number of the stroke"},
    {"speed", "m/s", "speed of the push"},
    {"seen", "m", "travel to the visible surface; null if never reached"},
    {"touched", "m", "travel to the first ellipsoid; null if none is touched"},
    {"felt", "m", "travel to the force onset; null if there is no force"},
    {"late", "m", "onset delay; null if unknown"},
    {"silent", "", "true if the force stays below a tenth of stiffness times depth deep inside"},
    {"sunk", "", "true if the proxy sinks into the surface"},
    {"through", "", "true if the proxy passes through to the far side"},
    {"stuck", "", "true if the stroke ends with a residual force"},
    {"step", "N", "largest force change in a tick beyond stiffness times the tool motion"},
};

const Names kStrokeTicks{
    {"t", "s", "time"},
    {"x", "m", "position of the tool centre, x component, world frame"},
    {"y", "m", "position of the tool centre, y component, world frame"},
    {"z", "m", "position of the tool centre, z component, world frame"},
    {"proxy_x", "m", "position of the proxy, x component, world frame"},
    {"proxy_y", "m", "position of the proxy, y component, world frame"},
    {"proxy_z", "m", "position of the proxy, z component, world frame"},
    {"fx", "N", "force on the tool, x component, world frame"},
    {"fy", "N", "force on the tool, y component, world frame"},
    {"fz", "N", "force on the tool, z component, world frame"},
    {"depth_m", "m", "depth of the tool in the true surface"},
    {"proxy_depth_m", "m", "depth of the proxy in the true surface"},
    {"confidence", "1", "confidence that a surface exists"},
};

const Names kStabilityCsv{
    {"profile", "", "device profile"},
    {"hand_mass", "kg", "mass of the hand"},
    {"hand_damping", "N s/m", "damping of the hand"},
    {"hand_stiffness", "N/m", "stiffness of the hand"},
    {"model", "", "force model"},
    {"contacts", "", "contact search: loop, worker or hold"},
    {"delay_ms", "ms", "delay of worker or hold"},
    {"limit_cycle_mm", "mm", "oscillation at rest, peak to peak"},
    {"port_energy_mj", "mJ", "net energy output at the device port"},
    {"contact_changes", "1", "number of times the force starts or ends"},
    {"rest_force_n", "N", "force at rest, minimum over all places"},
    {"slide_force_off", "1",
     "relative force deviation from the in-loop search while sliding, 95th percentile"},
    {"fault", "word", "fault that withholds the force"},
    {"z_width_n_m", "N/m", "Z-width: largest stable stiffness; empty for density"},
};

const Names kStability{
    {"made", "", "provenance (see `made`)"},
    {"rows[].profile", "", "device profile"},
    {"rows[].hand", "kg, N s/m, N/m", "mass, damping and stiffness of the hand; null for an ideal wall"},
    {"rows[].model", "", "force model, or wall"},
    {"rows[].hold_ms", "ms", "delay of the held force"},
    {"rows[].worker_ms", "ms", "delay of the worker"},
    {"rows[].limit_cycle_mm", "mm", "oscillation at rest, peak to peak"},
    {"rows[].port_energy_mj", "mJ", "net energy output at the device port"},
    {"rows[].contact_changes", "1", "number of times the force starts or ends"},
    {"rows[].rest_force", "N", "force at rest, minimum over all places"},
    {"rows[].slide_force_off", "1",
     "relative force deviation from the in-loop search while sliding, 95th percentile"},
    {"rows[].fault", "word", "fault that withholds the force"},
    {"rows[].z_width", "N/m", "Z-width: largest stable stiffness; null for density"},
    {"rows[].passivity", "", "ideal wall: true with the passivity controller"},
    {"rows[].z_width_bound", "N/m", "ideal wall: theoretical limit of the Z-width"},
};

const Names kReproduceCsv{
    {"run", "", "force model of the run"},
    {"t", "s", "time"},
    {"x", "m", "position of the tool centre, x component, world frame"},
    {"y", "m", "position of the tool centre, y component, world frame"},
    {"z", "m", "position of the tool centre, z component, world frame"},
    {"candidates", "1", "Gaussians after the broad phase"},
    {"filtered", "1", "candidates after the bounding-sphere test"},
    {"colliding", "1", "filtered Gaussians that overlap the tool"},
    {"fx", "N", "force on the tool, x component, world frame"},
    {"fy", "N", "force on the tool, y component, world frame"},
    {"fz", "N", "force on the tool, z component, world frame"},
    {"ufx", "N", "force of the user, x component, world frame"},
    {"ufy", "N", "force of the user, y component, world frame"},
    {"ufz", "N", "force of the user, z component, world frame"},
    {"cpu_us", "us", "processor time of contacts and force"},
    {"wall_us", "us", "wall-clock time of contacts and force"},
    {"true_depth", "m", "depth of the tool in the true surface; empty if the surface is unknown"},
};

const Names kReproduce{
    {"setup", "", "description of the experiment"},
    {"claims[].paper", "", "claim of the paper"},
    {"claims[].figure", "", "value stated by the paper"},
    {"claims[].measured", "", "measured quantity"},
    {"claims[].bound", "", "bound within which the claim holds"},
    {"claims[].paper_pipeline", "as measured", "value with the paper's pipeline and force; null if unknown"},
    {"claims[].default", "as measured", "value with the project's defaults; null if unknown"},
    {"claims[].met", "", "true if the default is within the bound; null if unknown"},
    {"claims[].ratio", "1", "factor by which the default is better than the bound; null if unknown"},
    {"runs[].model", "", "force model"},
    {"runs[].device", "", "admittance or impedance"},
    {"runs[].held_ms", "ms", "hold time of the force"},
    {"runs[].port_energy_mj", "mJ", "net energy output at the device port"},
    {"runs[].held_ticks", "1", "ticks in which a device limit holds the motion"},
    {"runs[].faults", "word", "faults that occurred, once each"},
    {"runs[].contacts[].begins", "s", "start time of the contact; null if there is none"},
    {"runs[].contacts[].colliding", "1", "largest number of simultaneously colliding Gaussians"},
    {"runs[].contacts[].force", "N", "force at rest"},
    {"runs[].contacts[].user_force", "N", "force of the user at rest"},
    {"runs[].contacts[].direction", "1", "direction of the force, world frame"},
    {"runs[].contacts[].swing_mm", "mm", "oscillation at rest, peak to peak about a linear fit"},
    {"runs[].contacts[].overshoot_mm", "mm", "overshoot: largest depth beyond the rest position"},
    {"runs[].contacts[].bounces", "1", "number of rebounds that end the force before rest"},
    {"runs[].contacts[].true_depth_mm", "mm",
     "depth at rest in the true surface; null if the surface is unknown"},
    {"runs[].contacts[].off_deg", "deg",
     "angle between the force and the true normal; null if the surface is unknown"},
    {"made", "", "provenance (see `made`)"},
};

std::string_view presence(const RunColumn& column) {
  switch (column.group) {
    case ColumnGroup::kUserForce: return "if the handle measures force";
    case ColumnGroup::kLive: return column.may_lack ? "live; absent from early recordings" : "live";
    default: return "always";
  }
}

/// Builds the page.
class Page {
 public:
  void all() {
    print(
        "# Columns and fields\n\nEvery column of a CSV file and every field of `--json`. This page is the "
        "output of `palpate columns`; a test checks it against the output of the commands.\n\nNumbers are "
        "in SI units unless a name states another unit, and round-trip exactly. A CSV file begins with "
        "comment lines, each after `#`: TOML with the provenance of the file, in the tables `[made]` and "
        "`[settings]`; then follows the line of column names. In JSON the provenance is the object `made`. "
        "`[]` stands for each element of an array; an object whose fields are not listed is described as a "
        "whole.\n");
    table("Trajectories",
          "Written by `palpate make-path` and `palpate evaluate --worst`, read by `--trajectory`. Columns "
          "may be in any order; others are ignored.",
          "column", kTrajectory);
    runs();
    table("`made`",
          "Provenance of a result. In the table `[made]` of a CSV file the names have `-` in place of `_`.",
          "field", kMade);
    table("`palpate info --json`", "Contents of a scene file, and the result of the filter.", "field", kInfo);
    table("`palpate setup --json`", "Proposed options, each an object of `value` and `reason`.", "field",
          kSetup);
    table("`palpate query --json`", "Contacts and wrench at one pose.", "field", kQuery);
    table("`palpate replay --json`", "Summary of the run.", "field", kReplay);
    table("`palpate run --json`", "Summary of the live loop.", "field", kRun);
    table("`palpate bench --json`", "Latency and throughput of contact queries.", "field", kBench);
    evaluate();
    capture();
    trials();
    table("`palpate stability`", "`--csv`: one row per device, hand, force model and contact search.",
          "column", kStabilityCsv);
    table("`palpate stability --json`", "The same figures, and the Z-width of ideal walls.", "field",
          kStability);
    table("`palpate reproduce`", "`--csv`: one row per tick of the first two runs.", "column", kReproduceCsv);
    table("`palpate reproduce --json`", "Claims of the paper and simulated runs.", "field", kReproduce);
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
    print("\n## {}\n\n{}\n\n| {} | unit | description |\n|---|---|---|\n", title, note, what);
  }

  void table(std::string_view title, std::string_view note, std::string_view what, const Names& names) {
    begin(title, note, what);
    rows("", names);
  }

  void runs() {
    print(
        "\n## Runs\n\nOutput of `palpate replay` and recordings of live loops: one row per pose or tick. "
        "`live`: only in recordings of a live loop.\n\n| column | unit | present | description "
        "|\n|---|---|---|---|\n");
    for (const RunColumn& column : run_columns())
      print("| `{}` | {} | {} | {} |\n", column.name, column.unit, presence(column), column.help);
    for (const RunColumn& column : run_columns()) {
      if (column.words.empty()) continue;
      print("\n`{}` is one of", column.name);
      for (const std::string_view word : column.words) print(" `{}`", word);
      print("; recordings of earlier versions contain its index, from 0.\n");
    }
  }

  /// Appends the columns of a printed table, whose note explains them.
  void section_rows(std::string_view prefix, const EvaluationSection& section) {
    for (const EvaluationColumn& column : section.columns)
      print("| `{}{}` | in the name | {}: {} |\n", prefix, column.name, section.title, column.heading);
  }

  void evaluate() {
    begin("`palpate evaluate`",
          "`--csv`: one row per shape, spacing and force model. The printed tables explain the figures.",
          "column");
    rows("", kEvaluateRow);
    for (const EvaluationSection& section : evaluation_sections()) section_rows("", section);
    begin("`palpate evaluate --json`", "The same figures.", "field");
    rows("", {{"made", "", "provenance (see `made`)"}});
    rows("rows[].", kEvaluateRow);
    for (const EvaluationSection& section : evaluation_sections()) section_rows("rows[].", section);
    rows("rows[].", {{"curves", "in the name",
                      "values along a path: position, then the 5th, 50th and 95th percentile"}});
  }

  void capture() {
    const auto columns = [this](std::string_view prefix) {
      print("| `{}model` |  | force model |\n", prefix);
      for (const auto& column : capture_columns())
        print("| `{}{}` | in the name | {} |\n", prefix, column.name, column.heading);
    };
    begin("`palpate evaluate --scene`", "`--csv`: one row per force model.", "column");
    columns("");
    begin("`palpate evaluate --scene --json`", "The same figures.", "field");
    rows("", {{"made", "", "provenance (see `made`)"}});
    columns("rows[].");
  }

  void trials() {
    table("`palpate evaluate --trials`", "`--csv`: one row per tool, place and kind of capture.", "column",
          kTrialRow);
    begin("`palpate evaluate --trials --json`", "The same figures.", "field");
    rows("", {{"made", "", "provenance (see `made`)"}});
    rows("rows[].", kTrialRow);
    rows("rows[].", kTrialLists);
    table("`palpate evaluate --trials --stroke`", "`--csv`: one row per tick of one stroke.", "column",
          kStrokeTicks);
    table("`palpate evaluate --trials --stroke --json`", "Result of one stroke.", "field", kStroke);
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
