// palpate replay: every pose of a trajectory, offline and deterministic.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <palpate/base/error.h>
#include <palpate/base/version.h>
#include <palpate/record/playback.h>

#include "command.h"
#include "config.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "run_origin.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct Options {
  CommonOptions common;
  LiveConfig live;
  QueryOptions query;
  std::string from;
  std::string trajectory;
  std::string out;
  int threads = 0;
};

Json to_json(const std::vector<RunRow>& rows) {
  const RunSummary summary = summarize(rows);
  return {
      {"poses", rows.size()},
      {"seconds", summary.seconds},
      {"contact_poses", summary.contact_rows},
      {"episodes", contact_episodes(rows).size()},
      {"colliding_max", summary.most_colliding},
      {"force_max", summary.largest_force},
      {"compute_us",
       {{"p50", summary.compute_us.p50}, {"p99", summary.compute_us.p99}, {"max", summary.compute_us.max}}}};
}

void print_episodes(const std::vector<RunRow>& rows) {
  constexpr std::size_t kShown = 30;
  const auto episodes = contact_episodes(rows);
  if (episodes.empty()) {
    fmt::print("no contact\n");
    return;
  }
  fmt::print("{:>7} {:>9} {:>9} {:>9} {:>11}  {}\n", "contact", "onset s", "for s", "colliding", "max |F| N",
             "tool at onset, m");
  for (std::size_t k = 0; k < std::min(kShown, episodes.size()); ++k) {
    const Episode& e = episodes[k];
    const Eigen::Vector3d& p = rows[e.first].tool.position;
    fmt::print("{:>7} {:>9.3f} {:>9.3f} {:>9} {:>11.3f}  {:.4f} {:.4f} {:.4f}\n", k + 1, rows[e.first].t,
               rows[e.last].t - rows[e.first].t, e.most_colliding, e.peak_force, p.x(), p.y(), p.z());
  }
  if (episodes.size() > kShown) fmt::print("  ... and {} more\n", episodes.size() - kShown);
}

void print_text(const std::vector<RunRow>& rows) {
  print_episodes(rows);
  const RunSummary s = summarize(rows);
  fmt::print(
      "\n{} poses over {:.2f} s, {} in contact, up to {} colliding, up to {:.2f} N; compute p50 {:.1f} us, "
      "p99 {:.1f} us, max {:.0f} us\n",
      rows.size(), s.seconds, s.contact_rows, s.most_colliding, s.largest_force, s.compute_us.p50,
      s.compute_us.p99, s.compute_us.max);
}

void settle(Options& options) {
  const RunOrigin origin(options.from);
  origin.settle(options.live);
  if (origin.version() != version()) {
    notify(fmt::format("note: {}: was made by palpate {}, and this is {}: figures may differ", options.from,
                       origin.version(), version()));
  }
}

void run(Options& options) {
  if (!options.from.empty()) settle(options);
  check_output(options.out, {options.from, options.trajectory, options.live.scene.path,
                             options.live.force.materials, options.common.config});
  const Progress progress = terminal_progress(options.common.quiet);
  const auto parallelism =
      options.threads > 0 ? static_cast<std::size_t>(options.threads)
                          : tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, parallelism);

  const Trajectory trajectory = read_trajectory(options.trajectory);
  const Pipeline pipeline = options.query.build(options.live, progress);
  const auto model = options.query.build_model(options.live, pipeline, progress);
  const std::vector<RunRow> rows =
      play_back(pipeline.query(), options.live.tool, *model, trajectory, progress);
  const Provenance known = made_by(options.common, options.live, options.query, pipeline);
  write_run(rows, options.out, to_toml(known), progress);

  if (options.common.json) {
    Json json = to_json(rows);
    json["made"] = made_json(known);
    if (pipeline.paper) add_reach(*pipeline.paper, options.live.tool, json);
    print_json(json);
  } else if (!options.common.quiet) {
    print_text(rows);
    if (pipeline.paper) print_reach(*pipeline.paper, options.live.tool);
    fmt::print("wrote {}\n", printable(options.out));
  }
}

}  // namespace

Command declare_replay(CLI::App& parent) {
  CLI::App& app = add_command(parent, "replay", "Every pose of a trajectory file, offline and deterministic");
  auto options = std::make_shared<Options>();
  declare_common(app, options->common, "print the summary as JSON");
  declare_scene(app, options->live, SceneArgument::kOptionalPositional);
  need_one(app, "SCENE", kFromRun);
  add_text(
      app, kFromRun, options->from, "RUN.csv",
      "repeat a run: its settings and its poses, where no option says otherwise; SCENE if that has moved");
  add_text(app, "--trajectory", options->trajectory, "T.csv", "tool poses in the world: t,x,y,z,qw,qx,qy,qz")
      .required();
  add_text(app, "--out", options->out, "RUN.csv", "the run: contacts, wrench and time of every pose")
      .required();
  add_count(app, "--threads", options->threads, 1, kMostThreads,
            "how many (default: all); the result does not depend on it");
  declare_field(app, options->live, "tool");
  options->query.declare(app, options->live);
  declare_group(app, options->live, ConfigGroup::kForce);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
