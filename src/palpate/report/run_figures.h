/// \file
/// Plots of one run, or of several overlaid runs.
#pragma once

#include <string>
#include <vector>

#include <palpate/record/run_log.h>
#include <palpate/report/plot.h>

namespace palpate {

/// The rows of the paper's Fig. 5: collision count, force, user force and force sent where they are recorded,
/// and computing time. Of one run all counts and components; of several the contacts and magnitudes, a line a
/// run. \pre runs is not empty, nor any of them
std::vector<Plot> run_figures(const std::vector<Run>& runs);

}  // namespace palpate
