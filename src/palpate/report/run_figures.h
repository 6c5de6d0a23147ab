/// \file
/// Plots of one run, or of several overlaid runs.
#pragma once

#include <string>
#include <vector>

#include <palpate/record/run_log.h>
#include <palpate/report/plot.h>

namespace palpate {

/// Plots the rows of the paper's Fig. 5: collision count, force, user force and sent force if they are
/// recorded, and computation time. One run shows all counts and components; several show contacts and
/// magnitudes, one line per run. \pre neither `runs` nor any of them is empty
std::vector<Plot> run_figures(const std::vector<Run>& runs);

}  // namespace palpate
