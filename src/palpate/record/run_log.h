/// \file
/// Run format: a CSV file with one row per tick of pose, contacts and force.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/record/run_row.h>

namespace palpate {

/// A recorded or replayed run, in chronological order.
struct Run {
  std::string source;  ///< file name, for titles and messages
  std::vector<RunRow> rows;
  std::string made;  ///< how it was made, as passed to write_run(); empty if the file does not say
  bool cut = false;  ///< the last line was truncated and dropped: its writer was interrupted
};

/// Time window of a run, both ends inclusive. The whole run by default.
struct RunWindow {
  double from = -std::numeric_limits<double>::infinity();  ///< on the run's clock. Unit: [s].
  double to = std::numeric_limits<double>::infinity();     ///< Unit: [s].
  std::size_t most_rows = 10'000'000;  ///< maximum rows: close to three hours at 1 kHz, 4 GB
};

/// Writes `made`, TOML that says how the run was made, as comment lines; then
/// `t,x,y,z,qw,qx,qy,qz,candidates,filtered,colliding,k_max,fx,fy,fz,tx,ty,tz,px,py,pz, compute_us`, then
/// `ufx,ufy,ufz` if the first row has a user force, then
/// `vx,vy,vz,wx,wy,wz,sfx,sfy,sfz,stx,sty,stz,state,fault,energy,stored,damping,margin,age_us` if it is live;
/// see run_columns(). Numbers read back exactly. The file appears atomically. \pre every number is finite
void write_run(const std::vector<RunRow>& rows, const std::string& path, const std::string& made = {},
               const Progress& progress = {});

/// Reads files of write_run() and Recorder; columns may be in any order, unknown columns are ignored. Data
/// outside the window is not read, except a few probes to find its beginning.
///
/// A recording may end anywhere if its writer is killed. A last line without a terminator is dropped if it
/// has too few values or a truncated number, and always in a run with live columns, whose last number may be
/// truncated as well.
///
/// \throws Error if a column is missing (also of a group that the file has in part), a row is malformed, time
/// does not increase, or the window has no rows or too many.
Run read_run(const std::string& path, const RunWindow& window, const Progress& progress = {});
/// Reads the whole run.
Run read_run(const std::string& path, const Progress& progress = {});

/// Summary statistics of a run.
struct RunSummary {
  double seconds = 0.0;  ///< from the first row to the last
  std::size_t contact_rows = 0;
  std::size_t most_colliding = 0;
  double largest_force = 0.0;  ///< Unit: [N].
  struct {
    double p50, p99, max;
  } compute_us = {};  ///< quantiles. Unit: [us].
};

/// \pre rows is not empty.
RunSummary summarize(const std::vector<RunRow>& rows);

/// One stretch of contact in a run.
struct Episode {
  std::size_t first, last;     ///< rows, both inclusive
  std::size_t peak;            ///< row of the largest force
  std::size_t most_colliding;  ///< largest number of contacts
  double peak_force;           ///< Unit: [N].
};

/// The episodes of contact; two are merged if the gap between them is shorter than `merge_gap` seconds (a
/// bouncing tool counts as one touch).
std::vector<Episode> contact_episodes(const std::vector<RunRow>& rows, double merge_gap = 0.05);

}  // namespace palpate
