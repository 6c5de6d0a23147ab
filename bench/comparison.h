/// \file
/// One scene, one sequence of poses, any number of pipelines: built, checked against the truth, timed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "bench_poses.h"
#include "bench_scene.h"
#include "measure.h"
#include "pipeline.h"
#include "truth.h"

namespace palpate::bench {

struct ComparisonOptions {
  std::size_t gaussians = 1'000'000;
  double spacing = BenchScene::kSpacing;  ///< Unit: [m].
  double sigma = 1.0;                     ///< ellipsoid of a Gaussian, in standard deviations
  double search_radius = 0.0;             ///< of the paper's kd-tree; 0 for its own default. Unit: [m].
  PoseOptions poses;                      ///< its seed is the scene's too
  int rounds = 3;
  bool every_target = true;  ///< this library on all instruction sets, not only the best
};

struct PipelineResult {
  std::string name;
  Family family;
  double build_seconds = 0.0;     ///< of what it shares with others of its family, all cores
  std::size_t bytes = 0;          ///< growth of the resident set by the build
  Latency contact{{}}, free{{}};  ///< over the poses that touch something, and over the others
  Accuracy accuracy;
};

struct Comparison {
  ComparisonOptions options;
  std::size_t contact_poses = 0;
  std::size_t hits = 0;                               ///< of all poses, in truth
  double search_radius = 0.0, complete_radius = 0.0;  ///< as in PipelineInput. Unit: [m].
  std::vector<PipelineResult> results;

  double hits_per_contact_pose() const;
};

/// Checks pipelines against the truth and times them, by comparison.options. Fills in the counts of contacts,
/// and accuracy and times of comparison.results, of which there is one for each pipeline. Says on stderr what
/// it is doing.
void run(Pipelines& pipelines, const std::vector<Ellipsoid>& poses, const Truth& truth,
         Comparison& comparison);

/// On a scene that is made for it. Says on stderr what it is doing.
Comparison compare(const ComparisonOptions& options, const std::vector<Family>& families);

}  // namespace palpate::bench
