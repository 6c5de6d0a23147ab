#include <palpate/servo/run_log.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/base/quantile.h>

namespace palpate {
namespace {

constexpr std::array kColumns{"t",          "x",        "y",         "z",     "qw", "qx",        "qy", "qz",
                              "candidates", "filtered", "colliding", "k_max", "fx", "fy",        "fz", "tx",
                              "ty",         "tz",       "px",        "py",    "pz", "compute_us"};
constexpr std::array kUserForceColumns{"ufx", "ufy", "ufz"};
using Values = std::array<double, kColumns.size() + kUserForceColumns.size()>;

Values to_values(const RunRow& r) {
  const auto& p = r.tool.position;
  const auto& q = r.tool.orientation;
  const Eigen::Vector3d user = r.user_force.value_or(Eigen::Vector3d::Zero());
  const auto count = [](std::size_t n) { return static_cast<double>(n); };
  return {r.t,
          p.x(),
          p.y(),
          p.z(),
          q.w(),
          q.x(),
          q.y(),
          q.z(),
          count(r.candidates),
          count(r.filtered),
          count(r.colliding),
          r.k_max,
          r.wrench.force.x(),
          r.wrench.force.y(),
          r.wrench.force.z(),
          r.wrench.torque.x(),
          r.wrench.torque.y(),
          r.wrench.torque.z(),
          r.proxy.x(),
          r.proxy.y(),
          r.proxy.z(),
          r.compute_us,
          user.x(),
          user.y(),
          user.z()};
}

RunRow from_values(const Values& v, bool has_user_force) {
  const auto count = [](double value) { return static_cast<std::size_t>(value); };
  RunRow row;
  row.t = v[0];
  row.tool.position = {v[1], v[2], v[3]};
  row.tool.orientation = {v[4], v[5], v[6], v[7]};
  row.candidates = count(v[8]);
  row.filtered = count(v[9]);
  row.colliding = count(v[10]);
  row.k_max = v[11];
  row.wrench = {{v[12], v[13], v[14]}, {v[15], v[16], v[17]}};
  row.proxy = {v[18], v[19], v[20]};
  row.compute_us = v[21];
  if (has_user_force) row.user_force = Eigen::Vector3d(v[22], v[23], v[24]);
  return row;
}

void check_counts(const CsvTable& table, std::size_t row, const Values& values) {
  constexpr double kMaxCount = 4294967295.0;
  for (std::size_t k = 8; k <= 10; ++k) {
    if (!(values[k] >= 0.0 && values[k] <= kMaxCount && values[k] == std::floor(values[k]))) {
      throw Error("{}: line {}: column '{}': {} is not a count", table.source, table.lines[row], kColumns[k],
                  values[k]);
    }
  }
}

}  // namespace

void write_run(const std::vector<RunRow>& rows, const std::string& path, const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 14;
  const bool user_force = !rows.empty() && rows.front().user_force.has_value();
  std::string text;
  for (const char* name : kColumns) text += fmt::format("{}{}", text.empty() ? "" : ",", name);
  if (user_force) {
    for (const char* name : kUserForceColumns) text += fmt::format(",{}", name);
  }
  text += '\n';

  OutputFile file(path);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Values values = to_values(rows[i]);
    append_csv_row(text, std::span(values).first(user_force ? values.size() : kColumns.size()));
    file.write(text);
    text.clear();
    if (i % kRowsPerReport == 0)
      report(progress, "writing", static_cast<double>(i) / static_cast<double>(rows.size()));
  }
  file.write(text);
  file.commit();
  report(progress, "writing", 1.0);
}

Run read_run(const std::string& path, const Progress& progress) {
  const CsvTable table = read_csv(path, progress);
  std::vector<std::size_t> columns;
  columns.reserve(kColumns.size() + kUserForceColumns.size());
  for (const char* name : kColumns) columns.push_back(table.column(name));
  const bool user_force = table.has(kUserForceColumns[0]);
  if (user_force) {
    for (const char* name : kUserForceColumns) columns.push_back(table.column(name));
  }
  if (table.rows() == 0) throw Error("{}: has no rows; replay a trajectory first", path);

  Run run{path, {}};
  run.rows.reserve(table.rows());
  Values values{};
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t k = 0; k < columns.size(); ++k) values[k] = table.at(row, columns[k]);
    check_counts(table, row, values);
    if (!run.rows.empty() && !(values[0] > run.rows.back().t)) {
      throw Error("{}: line {}: column 't': {} does not follow {}; rows must be in order of time", path,
                  table.lines[row], values[0], run.rows.back().t);
    }
    run.rows.push_back(from_values(values, user_force));
  }
  return run;
}

RunSummary summarize(const std::vector<RunRow>& rows) {
  RunSummary summary;
  summary.seconds = rows.back().t - rows.front().t;
  std::vector<double> compute;
  compute.reserve(rows.size());
  for (const RunRow& row : rows) {
    compute.push_back(row.compute_us);
    summary.contact_rows += row.colliding != 0 ? 1 : 0;
    summary.most_colliding = std::max(summary.most_colliding, row.colliding);
    summary.largest_force = std::max(summary.largest_force, row.wrench.force.norm());
  }
  summary.compute_us = {quantile(compute, 0.5), quantile(compute, 0.99), quantile(compute, 1.0)};
  return summary;
}

std::vector<Episode> contact_episodes(const std::vector<RunRow>& rows, double merge_gap) {
  std::vector<Episode> episodes;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].colliding == 0) continue;
    const double force = rows[i].wrench.force.norm();
    if (episodes.empty() || rows[i].t - rows[episodes.back().last].t >= merge_gap) {
      // A row right after the last one continues its episode, however far apart rows are in time.
      if (episodes.empty() || episodes.back().last + 1 != i) {
        episodes.push_back({i, i, i, rows[i].colliding, force});
        continue;
      }
    }
    Episode& episode = episodes.back();
    episode.last = i;
    episode.most_colliding = std::max(episode.most_colliding, rows[i].colliding);
    if (force > episode.peak_force) {
      episode.peak_force = force;
      episode.peak = i;
    }
  }
  return episodes;
}

}  // namespace palpate
