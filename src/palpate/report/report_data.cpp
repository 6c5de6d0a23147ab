#include <palpate/report/report_data.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <palpate/haptics/tool_query.h>
#include <palpate/record/run_columns.h>
#include <palpate/report/ordered_json.h>

namespace palpate {
namespace {

constexpr std::size_t kMaxRows = 300'000;       // rows drawn: a browser stays fluent
constexpr std::size_t kMaxContactRows = 3'000;  // rows queried again
constexpr std::size_t kMaxContactPoints = 30'000;
constexpr std::size_t kMaxScenePoints = 60'000;

/// Returns the stride that keeps at most `most` of `n` items.
std::size_t stride_for(std::size_t n, std::size_t most) {
  return std::max<std::size_t>(1, (n + most - 1) / most);
}

/// Appends `"name":[v0,v1,...]` with `digits` significant digits.
template <typename Values>
void append_array(std::string& out, std::string_view name, const Values& values, int digits) {
  fmt::format_to(std::back_inserter(out), "{}\"{}\":[", out.ends_with('{') ? "" : ",", name);
  const char* separator = "";
  for (const auto& value : values) {
    fmt::format_to(std::back_inserter(out), "{}{:.{}g}", separator, static_cast<double>(value), digits);
    separator = ",";
  }
  out += ']';
}

/// Returns true for a column that is drawn over those of another run.
bool is_overlaid(std::string_view name) {
  constexpr std::array<std::string_view, 9> kThose{"t",   "colliding", "fx",  "fy",        "fz",
                                                   "sfx", "sfy",       "sfz", "compute_us"};
  return std::find(kThose.begin(), kThose.end(), name) != kThose.end();
}

/// Returns the object `columns` of every stride-th row. \param all false: only those drawn over another run
std::string columns_json(const Run& run, std::size_t stride, bool all = true) {
  std::string out = "{";
  std::vector<double> values;
  for (const RunColumn& column : run_columns(RunGroups::of(run.rows.front()))) {
    if (column.digits == 0 || !(all || is_overlaid(column.name))) continue;
    values.clear();
    for (std::size_t i = 0; i < run.rows.size(); i += stride) values.push_back(column.get(run.rows[i]));
    append_array(out, column.name, values, column.digits);
  }
  return out + "}";
}

OrderedJson episodes_json(const Run& run, std::size_t stride) {
  OrderedJson json = OrderedJson::array();
  for (const Episode& e : contact_episodes(run.rows)) {
    const RunRow& onset = run.rows[e.first];
    const auto& p = onset.tool.position;
    json.push_back({{"first", e.first / stride},
                    {"last", e.last / stride},
                    {"peak", e.peak / stride},
                    {"onset_t", onset.t},
                    {"duration_s", run.rows[e.last].t - onset.t},
                    {"position", {p.x(), p.y(), p.z()}},
                    {"peak_colliding", e.most_colliding},
                    {"peak_force", e.peak_force}});
  }
  return json;
}

/// Periods in which state and fault of the safety governor did not change.
struct GovernorStretches {
  std::vector<double> t;
  std::vector<std::size_t> row;  ///< first row of each
  std::vector<int> state, fault;
};

/// Finds the periods in every step-th row. \pre the run is live
GovernorStretches stretches_of(const Run& run, std::size_t step = 1) {
  GovernorStretches found;
  for (std::size_t i = 0; i < run.rows.size(); i += step) {
    const LiveColumns live = run.rows[i].live.value_or(LiveColumns{});
    const int state = static_cast<int>(live.state), fault = static_cast<int>(live.fault);
    if (!found.t.empty() && state == found.state.back() && fault == found.fault.back()) continue;
    found.t.push_back(run.rows[i].t);
    found.row.push_back(i);
    found.state.push_back(state);
    found.fault.push_back(fault);
  }
  return found.t.size() <= kMaxRows ? found : stretches_of(run, stride_for(run.rows.size(), kMaxRows));
}

/// Number of times that a fault begins.
std::size_t fault_count(const GovernorStretches& stretches) {
  std::size_t count = 0;
  int before = static_cast<int>(Fault::kNone);
  for (const int fault : stretches.fault) {
    count += fault != static_cast<int>(Fault::kNone) && fault != before ? 1 : 0;
    before = fault;
  }
  return count;
}

std::string governor_json(const GovernorStretches& stretches, std::size_t run_stride) {
  OrderedJson states = OrderedJson::array(), faults = OrderedJson::array();
  for (int k = 0; k <= static_cast<int>(GovernorState::kStopped); ++k)
    states.push_back(to_string(static_cast<GovernorState>(k)));
  for (std::size_t k = 0; k < kFaultCount; ++k) faults.push_back(traits(static_cast<Fault>(k)).name);
  std::vector<std::size_t> shown;
  for (const std::size_t row : stretches.row) shown.push_back(row / run_stride);
  std::string out = "{";
  append_array(out, "t", stretches.t, 12);
  append_array(out, "row", shown, 12);
  append_array(out, "state", stretches.state, 12);
  append_array(out, "fault", stretches.fault, 12);
  return out + fmt::format(",\"states\":{},\"faults\":{}}}", states.dump(), faults.dump());
}

std::string contacts_json(const RunContacts& contacts, std::size_t run_stride) {
  using Point = RunContacts::Point;
  const std::size_t stride = stride_for(contacts.points.size(), kMaxContactPoints);
  std::string out = "{";
  const auto column = [&](std::string_view name, int digits, auto get) {
    std::vector<double> values;
    for (std::size_t i = 0; i < contacts.points.size(); i += stride)
      values.push_back(get(contacts.points[i]));
    append_array(out, name, values, digits);
  };
  column("row", 12, [&](const Point& p) {
    const std::size_t shown = p.row / run_stride;
    return static_cast<double>(shown);
  });
  column("x", 7, [](const Point& p) { return p.contact.point.x(); });
  column("y", 7, [](const Point& p) { return p.contact.point.y(); });
  column("z", 7, [](const Point& p) { return p.contact.point.z(); });
  column("nx", 3, [](const Point& p) { return p.contact.normal.x(); });
  column("ny", 3, [](const Point& p) { return p.contact.normal.y(); });
  column("nz", 3, [](const Point& p) { return p.contact.normal.z(); });
  column("k_min", 4, [](const Point& p) { return p.contact.k_min; });
  column("depth", 4, [](const Point& p) { return p.contact.depth; });
  return out + "}";
}

std::string scene_json(const EllipsoidScene& scene) {
  const std::size_t stride = stride_for(scene.size(), kMaxScenePoints);
  std::vector<double> points, colors;
  for (std::size_t i = 0; i < scene.size(); i += stride) {
    const Eigen::Vector3d& c = scene.ellipsoids[i].center;
    points.insert(points.end(), {c.x(), c.y(), c.z()});
    for (std::size_t k = 0; k < 3; ++k) colors.push_back(scene.color.empty() ? 160 : scene.color[i][k]);
  }
  std::string out = "{";
  append_array(out, "points", points, 5);
  append_array(out, "colors", colors, 3);
  return out + "}";
}

OrderedJson summary_json(const Run& run, const GovernorStretches* stretches, std::size_t stride) {
  const RunSummary s = summarize(run.rows);
  OrderedJson json = OrderedJson::array();
  const auto add = [&](const char* label, const std::string& value) {
    json.push_back({{"label", label}, {"value", value}});
  };
  add("Poses", fmt::format("{}", run.rows.size()));
  add("Time", fmt::format("{:.2f} s", s.seconds));
  add("Contacts", fmt::format("{}", contact_episodes(run.rows).size()));
  add("In contact", fmt::format("{:.1f} %", 100.0 * static_cast<double>(s.contact_rows) /
                                                static_cast<double>(run.rows.size())));
  add("Largest force", fmt::format("{:.2f} N", s.largest_force));
  add("Computation time, median", fmt::format("{:.1f} \u00b5s", s.compute_us.p50));
  if (stretches != nullptr) add("Faults", fmt::format("{}", fault_count(*stretches)));
  if (stride > 1) add("Shown", fmt::format("every {}th pose", stride));
  return json;
}

std::string title_json(const Run& run) {
  return json_text(std::filesystem::path(run.source).filename().string());
}

std::string overlay_json(const Run& run) {
  const std::size_t stride = stride_for(run.rows.size(), kMaxRows);
  std::optional<GovernorStretches> stretches;
  if (run.rows.front().live) stretches = stretches_of(run);
  return fmt::format("{{\"title\":{},\"made\":{},\"summary\":{},\"columns\":{}}}", title_json(run),
                     json_text(run.made),
                     json_text(summary_json(run, stretches ? &*stretches : nullptr, stride)),
                     columns_json(run, stride, false));
}

/// Escapes '<': `</script>` in a file name must not end the element that holds the document.
std::string escaped(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

RunContacts find_contacts(const Run& run, const SceneIndex& index, const Tool& tool) {
  std::vector<std::size_t> touching;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    if (run.rows[i].colliding != 0) touching.push_back(i);
  }
  RunContacts result;
  ContactSet set;
  for (std::size_t k = 0; k < touching.size(); k += stride_for(touching.size(), kMaxContactRows)) {
    const std::size_t row = touching[k];
    query(index, tool, run.rows[row].tool, set);
    ++result.rows_checked;
    if (set.contacts.size() != run.rows[row].colliding) ++result.rows_differing;
    for (const Contact& contact : set.contacts) result.points.push_back({row, contact});
  }
  return result;
}

std::string report_json(const Run& run, const EllipsoidScene* scene, const Tool* tool,
                        const RunContacts* contacts, const std::string& version,
                        std::span<const Run> others) {
  const std::size_t stride = stride_for(run.rows.size(), kMaxRows);
  std::optional<GovernorStretches> stretches;
  if (run.rows.front().live) stretches = stretches_of(run);
  std::string out = fmt::format(
      "{{\"title\":{},\"generator\":\"{}\",\"made\":{},\"summary\":{},\"tool\":{},\"columns\":{},"
      "\"episodes\":{},"
      "\"governor\":{},\"contacts\":{},\"scene\":{}}}",
      title_json(run), version, json_text(run.made),
      json_text(summary_json(run, stretches ? &*stretches : nullptr, stride)),
      tool != nullptr ? json_text(tool_json(*tool)) : "null", columns_json(run, stride),
      json_text(episodes_json(run, stride)), stretches ? governor_json(*stretches, stride) : "null",
      contacts != nullptr ? contacts_json(*contacts, stride) : "null",
      scene != nullptr ? scene_json(*scene) : "null");
  if (!others.empty()) {
    out.back() = ',';
    out += "\"others\":[";
    for (const Run& other : others) out += overlay_json(other) + ',';
    out.back() = ']';
    out += '}';
  }
  return escaped(out);
}

}  // namespace palpate
