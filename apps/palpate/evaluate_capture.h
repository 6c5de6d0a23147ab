/// \file
/// `palpate evaluate --scene`: force models on a captured scene, compared with its visible surface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "options.h"

namespace palpate::cli {

struct CaptureOptions {
  LiveConfig live;      ///< only its scene is used; empty path: analytic shapes instead
  std::string against;  ///< another capture of the same object with the same registration; empty: none
  std::string worst;    ///< output folder for the worst pushes; empty: none
  int rays = 1000;      ///< number of rays over the tool's cross-section
  int slides = 50;

  void declare(CLI::App& app);
};

/// Other options of the command.
struct CaptureTask {
  CommonOptions common;
  Tool tool;
  ForceConfig force;
  std::vector<std::string> models;
  int pushes;
  std::uint64_t seed;
  ResultNames results;
};

void evaluate_capture(const CaptureOptions& options, const CaptureTask& task);

}  // namespace palpate::cli
