/// \file
/// `palpate evaluate --trials`: tools pushed at known solids, at several places and speeds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "options.h"

namespace palpate::cli {

struct TrialOptions {
  int strokes = 0;                 ///< per row; 0: the other evaluations instead
  std::vector<std::string> tools;  ///< names from trial_tools(), or tool files
  std::vector<std::string> places;
  std::vector<std::string> like;  ///< names from capture_defects(), or "even"
  int stroke = -1;                ///< number of the only stroke to run, of one row; negative: all

  TrialOptions();
  void declare(CLI::App& app);
};

/// Other options of the command.
struct TrialTask {
  CommonOptions common;
  ForceConfig force;
  std::uint64_t seed;
  std::string csv;
};

void evaluate_trials(const TrialOptions& options, const TrialTask& task);

}  // namespace palpate::cli
