/// \file
/// Tables of trials of any tool at any place, as text, CSV and JSON.
#pragma once

#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/report/ordered_json.h>
#include <palpate/study/trials.h>

namespace palpate {

/// Trials of a tool at a place of a scene.
struct TrialRow {
  std::string tool, place;
  std::string like;  ///< capture defects of the scene
  TrialSetup setup;
  TrialFigures figures;
};

/// Computes the figures of all rows, on all processors.
void measure_trials(std::vector<TrialRow>& rows, const Progress& progress);

std::string trial_text(const std::vector<TrialRow>& rows);

/// Returns one object per row, with all figures and the numbers of the failed strokes.
OrderedJson trial_json(const std::vector<TrialRow>& rows);

/// Returns one line per row.
std::string trial_csv(const std::vector<TrialRow>& rows);

/// Describes one stroke of a row, in a line.
std::string trial_stroke_text(const TrialRow& row, const TrialStroke& stroke);

/// Returns the row's names and all figures of one stroke; null where there is none.
OrderedJson trial_stroke_json(const TrialRow& row, const TrialStroke& stroke);

/// Returns one line per tick of a stroke, 1 ms apart.
std::string trial_ticks_csv(const std::vector<TrialTick>& ticks);

}  // namespace palpate
