/// \file
/// `palpate evaluate --scene`: force models on a captured scene, compared with its visible surface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "options.h"

namespace palpate::cli {

struct CaptureOptions {
  LiveConfig live;      ///< its scene; the analytic shapes instead if its path is empty
  std::string against;  ///< another capture of the same object, registered alike; empty: none
  std::string worst;    ///< folder for the worst pushes; empty: none
  int rays = 1000;      ///< of a tool's cross-section
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
  std::string csv, html, svg;
};

void evaluate_capture(const CaptureOptions& options, const CaptureTask& task);

}  // namespace palpate::cli
