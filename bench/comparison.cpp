#include "comparison.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/core.h>

#include <palpate/collision/paper_pipeline.h>

namespace palpate::bench {
namespace {

/// Builds a family and appends one result per pipeline, with the build's time and memory.
void build(const Family& family, const PipelineInput& input, Pipelines& pipelines,
           std::vector<PipelineResult>& results) {
  fmt::print(stderr, "building {}\n", family.name);
  const std::size_t before = resident_bytes();
  const Stopwatch watch;
  Pipelines built = family.build(input);
  const double seconds = watch.seconds();
  const std::size_t after = resident_bytes();
  for (const auto& pipeline : built) {
    PipelineResult& result = results.emplace_back();
    result.name = pipeline->name();
    result.family = family;
    result.build_seconds = seconds;
    result.bytes = after - std::min(before, after);
  }
  std::move(built.begin(), built.end(), std::back_inserter(pipelines));
}

Accuracy check(Pipeline& pipeline, const std::vector<Ellipsoid>& poses, const Truth& truth) {
  Accuracy accuracy;
  std::vector<Hit> found;
  pipeline.prepare();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    pipeline.query(poses[i]);
    pipeline.hits(found);
    accuracy.add(truth[i], found);
  }
  return accuracy;
}

/// Latency over the poses in contact, or over the others.
Latency latency(const std::vector<double>& times, const Truth& truth, bool touching) {
  std::vector<double> selected;
  for (std::size_t i = 0; i < times.size(); ++i)
    if (truth[i].empty() != touching) selected.push_back(times[i]);
  return Latency(std::move(selected));
}

/// Input of all pipelines, and the ground truth.
struct Setting {
  GaussianScene scene;
  SceneFilter filter;
  EllipsoidScene ellipsoids;
  std::vector<Ellipsoid> poses;
  Truth truth;

  explicit Setting(const ComparisonOptions& options) {
    fmt::print(stderr, "making {} Gaussians and {} poses\n", options.gaussians, options.poses.count);
    const BenchScene bench_scene(options.gaussians, options.poses.seed, options.spacing);
    poses = make_poses(bench_scene, options.poses);
    scene = bench_scene.load();
    filter.sigma = options.sigma;
    FilterReport report;
    ellipsoids = filter_scene(scene, filter, Similarity{}, report);
    fmt::print(stderr, "computing the truth\n");
    TruthFinder finder(poses);
    finder.add(ellipsoids);
    truth = finder.take();
  }
};

/// Sets the search radii of the paper's pipeline.
void find_radii(const Setting& setting, Comparison& comparison) {
  const double tool_radius = comparison.options.poses.tool.maxCoeff();
  const double asked = comparison.options.search_radius;
  comparison.search_radius =
      asked > 0.0 ? asked : PaperPipeline::default_search_radius(setting.ellipsoids, tool_radius);
  for (const Ellipsoid& e : setting.ellipsoids.ellipsoids) {
    comparison.complete_radius = std::max(comparison.complete_radius, e.radius() + tool_radius);
  }
}

}  // namespace

double Comparison::hits_per_contact_pose() const {
  return contact_poses == 0 ? 0.0 : static_cast<double>(hits) / static_cast<double>(contact_poses);
}

void run(Pipelines& pipelines, const std::vector<Ellipsoid>& poses, const Truth& truth,
         Comparison& comparison) {
  for (const std::vector<Hit>& hits : truth) {
    comparison.contact_poses += hits.empty() ? 0 : 1;
    comparison.hits += hits.size();
  }
  std::vector<PipelineResult>& results = comparison.results;
  for (std::size_t p = 0; p < pipelines.size(); ++p) {
    fmt::print(stderr, "checking {}\n", pipelines[p]->name());
    results[p].accuracy = check(*pipelines[p], poses, truth);
  }
  fmt::print(stderr, "measuring {} rounds\n", comparison.options.rounds);
  const auto times = measure(pipelines, poses, comparison.options.rounds);
  for (std::size_t p = 0; p < pipelines.size(); ++p) {
    results[p].contact = latency(times[p], truth, true);
    results[p].free = latency(times[p], truth, false);
  }
}

Comparison compare(const ComparisonOptions& options, const std::vector<Family>& families) {
  const Setting setting(options);
  Comparison comparison;
  comparison.options = options;
  find_radii(setting, comparison);

  Pipelines pipelines;
  const PipelineInput input{setting.scene,
                            setting.filter,
                            setting.ellipsoids,
                            comparison.search_radius,
                            comparison.complete_radius,
                            options.every_target};
  for (const Family& family : families) build(family, input, pipelines, comparison.results);
  run(pipelines, setting.poses, setting.truth, comparison);
  return comparison;
}

}  // namespace palpate::bench
