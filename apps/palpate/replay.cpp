// palpate replay: contacts and wrench at every pose of a trajectory, offline and deterministic.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <palpate/base/error.h>
#include <palpate/base/version.h>
#include <palpate/live/run_origin.h>
#include <palpate/record/playback.h>
#include <palpate/report/run_table.h>

#include "command.h"
#include "config.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct ReplayOptions {
  CommonOptions common;
  LiveConfig live;
  QueryOptions query;
  std::string from;
  std::string trajectory;
  std::string out;
  int threads = 0;
};

void settle(ReplayOptions& options) {
  const RunOrigin origin(options.from);
  origin.settle(options.live);
  if (origin.version() != version()) {
    notify(fmt::format("note: {}: was made by palpate {}, and this is {}: results may differ", options.from,
                       origin.version(), version()));
  }
}

void run(ReplayOptions& options) {
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
    Json json = run_json(rows);
    json["made"] = made_json(known);
    if (pipeline.paper) add_reach(*pipeline.paper, options.live.tool, json);
    print_json(json);
  } else if (!options.common.quiet) {
    fmt::print("{}", run_text(rows));
    if (pipeline.paper) print_reach(*pipeline.paper, options.live.tool);
    fmt::print("wrote {}\n", printable(options.out));
  }
}

}  // namespace

Command declare_replay(CLI::App& parent) {
  CLI::App& app = add_command(
      parent, "replay", "Contacts and wrench at every pose of a trajectory file, offline and deterministic");
  auto options = std::make_shared<ReplayOptions>();
  declare_common(app, options->common, "print the summary as JSON");
  declare_scene(app, options->live, SceneArgument::kOptionalPositional);
  add_text(app, kFromRun, options->from, "RUN.csv",
           "repeat a run with its settings and poses, unless options override them; give SCENE if the scene "
           "file has moved");
  add_text(app, "--trajectory", options->trajectory, "T.csv",
           "tool poses, world frame: t,x,y,z,qw,qx,qy,qz; with --from, the poses of that run by default");
  need_unless(app, {"SCENE", "--trajectory"}, kFromRun);
  add_text(app, "--out", options->out, "RUN.csv",
           "output file: contacts, wrench and computation time of every pose")
      .required();
  add_count(app, "--threads", options->threads, 1, kMostThreads,
            "number of threads (default: all); does not affect the result");
  declare_field(app, options->live, "tool");
  options->query.declare(app, options->live);
  declare_group(app, options->live, ConfigGroup::kForce);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
