/// \file
/// The run format: one row a tick, what was asked, found and answered.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/record/run_row.h>

namespace palpate {

/// A recorded or replayed run, in order of time.
struct Run {
  std::string source;  ///< file name, for titles and messages
  std::vector<RunRow> rows;
  std::string made;  ///< how: what write_run() was told; empty if the file does not say
  bool cut = false;  ///< the last line of the file is cut, and left out: its writer was interrupted
};

/// A part of a run: the rows from one time to another, both inclusive. All of it by default.
struct RunWindow {
  double from = -std::numeric_limits<double>::infinity();  ///< on the run's clock. Unit: [s].
  double to = std::numeric_limits<double>::infinity();     ///< Unit: [s].
  std::size_t most_rows = 10'000'000;                      ///< that fit: close to three hours at 1 kHz, 4 GB
};

/// Writes a comment of the lines of `made`, TOML that says how the run was made; then
/// `t,x,y,z,qw,qx,qy,qz,candidates,filtered,colliding,k_max,fx,fy,fz,tx,ty,tz,px,py,pz, compute_us`, then
/// `ufx,ufy,ufz` if the first row has a user force, then
/// `vx,vy,vz,wx,wy,wz,sfx,sfy,sfz,stx,sty,stz,state,fault,energy,stored,damping,margin,age_us` if it is live;
/// see run_columns(). Numbers read back exactly. The file appears whole or not at all. \pre every number is
/// finite
void write_run(const std::vector<RunRow>& rows, const std::string& path, const std::string& made = {},
               const Progress& progress = {});

/// Reads what write_run() and Recorder write, columns in any order, further columns ignored. What is outside
/// the window is not read, but for a few steps to find where it begins.
///
/// A recording ends anywhere if its writer is killed. A last line without an end is left out if it has too
/// few values or a part of a number, and always in a run with live columns, whose last number may be cut as
/// well.
///
/// \throws Error if a column is missing (also of a group that the file has some of), a row is broken, time
/// does not increase, or the window has no rows or too many.
Run read_run(const std::string& path, const RunWindow& window, const Progress& progress = {});
/// All of it.
Run read_run(const std::string& path, const Progress& progress = {});

/// A run in a few figures.
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

/// The stretches of contact, two being one if the gap between them is shorter than `merge_gap`
/// seconds (a tool that bounces touches once).
std::vector<Episode> contact_episodes(const std::vector<RunRow>& rows, double merge_gap = 0.05);

}  // namespace palpate
