#include <palpate/servo/run_log.h>

#include <algorithm>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/servo/run_columns.h>

namespace palpate {
void write_run(const std::vector<RunRow>& rows, const std::string& path, const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 14;
  const std::vector<RunColumn> columns =
      run_columns(rows.empty() ? RunGroups{} : RunGroups::of(rows.front()));
  OutputFile file(path);
  std::string text = run_header(columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    append_run_row(text, rows[i], columns);
    file.write(text);
    text.clear();
    if (i % kRowsPerReport == 0)
      report(progress, "writing", static_cast<double>(i) / static_cast<double>(rows.size()));
  }
  file.write(text);
  file.commit();
  report(progress, "writing", 1.0);
}

namespace {

/// A column of a run, and which of the table's it is.
struct Source {
  RunColumn column;
  std::size_t index;
};

std::vector<Source> sources_of(const CsvTable& table) {
  RunGroups groups;
  for (const RunColumn& column : run_columns()) {
    if (!table.has(column.name)) continue;
    groups.user_force |= column.group == ColumnGroup::kUserForce;
    groups.live |= column.group == ColumnGroup::kLive;
  }
  std::vector<Source> sources;
  for (const RunColumn& column : run_columns(groups)) sources.push_back({column, table.column(column.name)});
  return sources;
}

RunRow row_of(const CsvTable& table, std::size_t row, const std::vector<Source>& sources) {
  RunRow made;
  for (const auto& [column, index] : sources) {
    const double value = table.at(row, index);
    if (!column.takes(value)) {
      throw Error("{}: line {}: column '{}': {} is not {}; whole numbers from 0 to {} are", table.source,
                  table.lines[row], column.name, value, column.whole_number, column.most);
    }
    column.set(made, value);
  }
  return made;
}

}  // namespace

Run read_run(const std::string& path, const Progress& progress) {
  const CsvTable table = read_csv(path, progress);
  const std::vector<Source> sources = sources_of(table);
  if (table.rows() == 0) throw Error("{}: has no rows; replay a trajectory first", path);

  Run run{path, {}};
  run.rows.reserve(table.rows());
  for (std::size_t k = 0; k < table.rows(); ++k) {
    const RunRow row = row_of(table, k, sources);
    if (!run.rows.empty() && !(row.t > run.rows.back().t)) {
      throw Error("{}: line {}: column 't': {} does not follow {}; rows must be in order of time", path,
                  table.lines[k], row.t, run.rows.back().t);
    }
    run.rows.push_back(row);
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
