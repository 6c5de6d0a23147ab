/// \file
/// Tables of trials of any tool at any place, as text, CSV and JSON.
#pragma once

#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/report/ordered_json.h>
#include <palpate/study/trials.h>

namespace palpate {

/// A tool at a place of a scene.
struct TrialRow {
  std::string tool, place;
  std::string like;  ///< defects of the scene
  TrialSetup setup;
  TrialFigures figures;
};

/// Computes the figures of all rows, on all processors.
void measure_trials(std::vector<TrialRow>& rows, const Progress& progress);

std::string trial_text(const std::vector<TrialRow>& rows);

/// One object a row, with all figures and which strokes failed.
OrderedJson trial_json(const std::vector<TrialRow>& rows);

/// One line a row.
std::string trial_csv(const std::vector<TrialRow>& rows);

/// One line a tick of a stroke, 1 ms each.
std::string trial_ticks_csv(const std::vector<TrialTick>& ticks);

}  // namespace palpate
