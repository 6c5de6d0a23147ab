// palpate bench: latency and throughput of the contact query on a scene and a path.
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/collision/simd_target.h>
#include <palpate/report/bench_table.h>
#include <palpate/study/latency.h>
#include <palpate/study/open_timing.h>
#include <palpate/study/touch_path.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct BenchOptions {
  CommonOptions common;
  LiveConfig live;
  QueryOptions query;
  std::string trajectory, histogram, simd;
  int rounds = 3;
  int threads = 0;
};

/// The contact query under test, and figures on how it was opened.
struct Opened {
  Pipeline pipeline;
  OpenFigures figures;
};

Opened open_exact(const BenchOptions& options, const Progress& progress) {
  const SceneConfig& scene = options.live.scene;
  const IndexFiles files = scene.no_index_file ? IndexFiles::kNone : IndexFiles::kUse;
  TimedIndex timed = time_opening(scene.path, scene.filter, scene.world_from_scene(), files, progress);
  return {{std::make_unique<SceneIndex>(std::move(timed.index)), nullptr}, std::move(timed.figures)};
}

Opened open_paper(const BenchOptions& options, const Progress& progress) {
  Opened opened;
  const Stopwatch watch;
  opened.pipeline = options.query.build(options.live, progress);
  opened.figures.seconds = watch.seconds();
  opened.figures.origin = "memory";
  // For an unbounded tool, can_miss() counts all Gaussians.
  opened.figures.gaussians = opened.pipeline.paper->can_miss(std::numeric_limits<double>::infinity());
  return opened;
}

Opened open_query(const BenchOptions& options, const Progress& progress) {
  const bool exact = options.query.is_exact();
  Opened opened = exact ? open_exact(options, progress) : open_paper(options, progress);
  measure_sizes(options.live.scene.path, opened.figures);
  if (opened.figures.gaussians == 0) {
    throw Error("{}: no Gaussian passes the filter, so there is nothing to time; see palpate info",
                options.live.scene.path);
  }
  return opened;
}

/// Reads the --trajectory, or else generates the path of make-path, the same for every pipeline.
Trajectory path_of(const BenchOptions& options, const SceneIndex* index, const Progress& progress) {
  if (!options.trajectory.empty()) return read_trajectory(options.trajectory);
  const LoadedScene loaded = load(options.live.scene, progress);
  try {
    if (index != nullptr) return touch_path(*index, loaded.kept, options.live.tool, {});
    const SceneIndex own(loaded.scene, options.live.scene.filter, options.live.scene.world_from_scene(),
                         progress);
    return touch_path(own, loaded.kept, options.live.tool, {});
  } catch (const Error& error) {
    throw Error("{}: {}; or give a --trajectory", options.live.scene.path, error.what());
  }
}

/// Poses in contact, or all poses if there are none.
std::vector<Pose> poses_for_batches(const BenchFigures& figures, const Trajectory& path) {
  const bool all = figures.contact_poses() == 0;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (all || figures.poses[i].contacts != 0) poses.push_back(path[i].pose);
  return poses;
}

BenchFigures measure(const BenchOptions& options, const Progress& progress) {
  Opened opened = open_query(options, progress);
  const TimedQuery timed{opened.pipeline.query(), opened.pipeline.index.get(), options.live.tool};
  const Trajectory path = path_of(options, timed.index, progress);

  BenchFigures figures;
  figures.scene = options.live.scene.path;
  figures.path = options.trajectory;
  figures.pipeline = options.query.pipeline;
  figures.simd = options.simd;
  figures.model = to_string(options.query.model(options.live));
  figures.tool_name = tool_in_words(options.live.tool);
  figures.tool = options.live.tool;
  figures.open = std::move(opened.figures);
  figures.rounds = options.rounds;
  figures.tracked = timed.index != nullptr;
  const auto model = options.query.build_model(options.live, opened.pipeline, progress);
  figures.poses = time_path(timed, path, *model, options.rounds, progress);

  using tbb::global_control;
  std::optional<global_control> limit;
  if (options.threads > 0) {
    limit.emplace(global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  }
  figures.threads = static_cast<int>(global_control::active_value(global_control::max_allowed_parallelism));
  figures.queries_per_second =
      time_batches(timed, poses_for_batches(figures, path), options.rounds, progress);
  return figures;
}

void run(BenchOptions& options) {
  check_output(
      options.histogram,
      {options.live.scene.path, options.trajectory, options.live.force.materials, options.common.config},
      "--histogram");
  check_ending(options.histogram, ".svg", "--histogram");
  if (options.simd.empty()) options.simd = simd_targets().front();
  use_simd_target(options.simd);
  const BenchFigures figures = measure(options, terminal_progress(options.common.quiet));
  if (!options.histogram.empty()) write_file(options.histogram, bench_histogram(figures));
  if (options.common.json) {
    using enum ConfigGroup;
    Json json = bench_json(figures);
    json["made"] = made_json(made_by(options.common, options.live, {kScene, kTool, kForce}));
    print_json(json);
    return;
  }
  if (options.common.quiet) return;
  fmt::print("{}", bench_text(figures, ::isatty(STDOUT_FILENO) != 0));
  if (!options.histogram.empty()) fmt::print("wrote {}\n", printable(options.histogram));
}

}  // namespace

Command declare_bench(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "bench", "Latency and throughput of the contact query on a scene and a path");
  auto options = std::make_shared<BenchOptions>();
  declare_common(app, options->common, "print figures as JSON");
  declare_scene(app, options->live, SceneArgument::kPositional);
  add_text(app, "--trajectory", options->trajectory, "T.csv",
           "tool poses, world frame (default: the path of make-path)");
  add_text(app, "--histogram", options->histogram, "H.svg",
           "output file of a latency histogram of fresh queries in contact");
  add_count(app, "--rounds", options->rounds, 1, 1000,
            "repetitions of the path; the minimum time per pose is used");
  add_count(app, "--threads", options->threads, 1, kMostThreads,
            "threads for the throughput (default: all); latency is measured on one thread");
  add_choice(app, "--simd", options->simd, simd_targets(), "instruction set (default: the best available)");
  declare_field(app, options->live, "tool");
  options->query.declare(app, options->live);
  declare_group(app, options->live, ConfigGroup::kForce);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli
