/// \file
/// What `palpate evaluate` has measured, as figures and as a page.
#pragma once

#include <string>
#include <vector>

#include "evaluate_table.h"
#include "plot.h"

namespace palpate::cli {

/// What the figures are drawn against.
struct EvaluationTruth {
  double stiffness;  ///< that proxy and field promise. Unit: [N/m].
  double depth;      ///< of the slides. Unit: [m].
};

/// Shown are the first shape and spacing, where there is a choice. \pre rows is not empty.
std::vector<Plot> evaluation_figures(const std::vector<EvaluationRow>& rows, const EvaluationTruth& truth);

/// A whole page that needs no network. `setup` says in a sentence what was done.
std::string evaluation_page(const std::vector<EvaluationRow>& rows, const std::vector<Plot>& figures,
                            const std::string& setup);

}  // namespace palpate::cli
