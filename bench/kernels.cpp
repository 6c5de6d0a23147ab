// Micro-benchmarks of the parts of a contact query.
#include <algorithm>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/k_function.h>
#include <palpate/collision/scene_index.h>

#include "bench_poses.h"
#include "bench_scene.h"

namespace palpate::bench {
namespace {

constexpr std::size_t kGaussians = 1'000'000;
constexpr double kNear =
    0.01;  // above the surface: many boxes overlap the tool's, few Gaussians do. Unit: [m].

const BenchScene& scene() {
  static const BenchScene made(kGaussians);
  return made;
}

const SceneIndex& index() {
  static const SceneIndex built(scene().load(), SceneFilter{}, Similarity{});
  return built;
}

std::vector<Ellipsoid> touching() { return make_poses(scene(), {}); }

/// Poses just above the places of touching().
std::vector<Ellipsoid> near() {
  std::vector<Ellipsoid> poses;
  for (std::size_t i = 0; i < PoseOptions{}.count; ++i) {
    HashRandom random(1, Purpose::kPose, i);
    poses.push_back(Stroke(scene(), kTool, random).at_depth(random.uniform(), -kNear));
  }
  return poses;
}

std::vector<Ellipsoid> far() {
  std::vector<Ellipsoid> poses = touching();
  for (Ellipsoid& tool : poses) tool.center[2] += scene().height();
  return poses;
}

/// Input pairs of a narrow phase: every 100th pose, and the Gaussians whose spheres overlap the tool's.
std::vector<std::pair<WhitenedTool, Ellipsoid>> pairs() {
  std::vector<std::pair<WhitenedTool, Ellipsoid>> found;
  constexpr std::size_t kEveryPose = 100;
  const std::vector<Ellipsoid> poses = touching();
  const GaussianScene gaussians = scene().load();
  for (std::size_t g = 0; g < gaussians.size(); ++g) {
    const Ellipsoid gaussian = world_ellipsoid(gaussians.gaussian(g), {}, {});
    for (std::size_t p = 0; p < poses.size(); p += kEveryPose) {
      if (spheres_overlap(poses[p], poses[p].radius(), gaussian, gaussian.radius())) {
        found.emplace_back(poses[p], gaussian);
      }
    }
  }
  return found;
}

void minimize_pair(benchmark::State& state) {
  const auto all = pairs();
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& [tool, gaussian] = all[i];
    benchmark::DoNotOptimize(minimize(KFunction(tool, gaussian)));
    i = i + 1 == all.size() ? 0 : i + 1;
  }
}
BENCHMARK(minimize_pair);

/// Measures the time of one query, and counts its contacts.
template <typename Query>
void run_queries(benchmark::State& state, const std::vector<Ellipsoid>& poses, const Query& query) {
  ContactSet contacts;
  std::size_t i = 0, hits = 0;
  for (auto _ : state) {
    query(poses[i], contacts);
    hits += contacts.contacts.size();
    i = i + 1 == poses.size() ? 0 : i + 1;
  }
  state.counters["contacts"] =
      benchmark::Counter(static_cast<double>(hits), benchmark::Counter::kAvgIterations);
}

void query_fresh(benchmark::State& state, std::vector<Ellipsoid> (*poses)()) {
  const SceneIndex& built = index();
  run_queries(state, poses(),
              [&](const Ellipsoid& tool, ContactSet& contacts) { built.query(tool, contacts); });
}
BENCHMARK_CAPTURE(query_fresh, contact, touching)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(query_fresh, near, near)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(query_fresh, far, far)->Unit(benchmark::kMicrosecond);

void query_tracked(benchmark::State& state) {
  ContactTracker tracker(index());
  run_queries(state, touching(),
              [&](const Ellipsoid& tool, ContactSet& contacts) { tracker.query(tool, contacts); });
}
BENCHMARK(query_tracked)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate::bench

BENCHMARK_MAIN();
