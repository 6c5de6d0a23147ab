#include <palpate/record/run_log.h>

#include <algorithm>

#include <palpate/base/file.h>
#include <palpate/base/quantile.h>
#include <palpate/record/run_columns.h>

namespace palpate {
void write_run(const std::vector<RunRow>& rows, const std::string& path, const std::string& made,
               const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 14;
  const std::vector<RunColumn> columns =
      run_columns(rows.empty() ? RunGroups{} : RunGroups::of(rows.front()));
  OutputFile file(path);
  std::string text = csv_comment(made) + run_header(columns);
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
