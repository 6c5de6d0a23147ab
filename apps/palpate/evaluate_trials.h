/// \file
/// `palpate evaluate --trials`: any tool pushed at any place of known solids, at any speed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "options.h"

namespace palpate::cli {

struct TrialOptions {
  int strokes = 0;                 ///< a row; none: the other evaluations instead
  std::vector<std::string> tools;  ///< of trial_tools(), or files of tools
  std::vector<std::string> places;
  std::vector<std::string> like;  ///< of capture_defects(), or even
  int stroke = -1;                ///< this one alone, of one row; negative: all

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
