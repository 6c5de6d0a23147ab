/// \file
/// Comparison of pipelines on one scene and one sequence of poses: build, check against ground truth, timing.
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
  double search_radius = 0.0;             ///< of the paper's kd-tree; 0: PaperPipeline's default. Unit: [m].
  PoseOptions poses;                      ///< the seed is also that of the scene
  int rounds = 3;
  bool every_target = true;  ///< run this library on all instruction sets, not only the best
};

struct PipelineResult {
  std::string name;
  Family family;
  double build_seconds = 0.0;     ///< of the structure shared by its family, on all cores
  std::size_t bytes = 0;          ///< growth of the resident set by the build
  Latency contact{{}}, free{{}};  ///< of the poses in contact, and of the others
  Accuracy accuracy;
};

struct Comparison {
  ComparisonOptions options;
  std::size_t contact_poses = 0;
  std::size_t hits = 0;                               ///< true contacts of all poses
  double search_radius = 0.0, complete_radius = 0.0;  ///< as in PipelineInput. Unit: [m].
  std::vector<PipelineResult> results;

  double hits_per_contact_pose() const;
};

/// Checks pipelines against the truth and times them, as set by comparison.options. Sets the counts of
/// contacts, and accuracy and times of comparison.results. Prints its progress on stderr.
/// \pre comparison.results has one element per pipeline
void run(Pipelines& pipelines, const std::vector<Ellipsoid>& poses, const Truth& truth,
         Comparison& comparison);

/// Compares `families` on a generated scene. Prints its progress on stderr.
Comparison compare(const ComparisonOptions& options, const std::vector<Family>& families);

}  // namespace palpate::bench
