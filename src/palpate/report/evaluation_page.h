/// \file
/// Figures and page of an evaluation against analytic surfaces.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/evaluation_table.h>
#include <palpate/report/plot.h>

namespace palpate {

/// Shown are the first shape and spacing, where there is a choice. \pre rows is not empty.
/// \param stiffness that proxy and field promise. Unit: [N/m].
std::vector<Plot> evaluation_figures(const std::vector<EvaluationRow>& rows, double stiffness);

/// A whole page that needs no network. `setup` says in a sentence what was done. \param made see
/// page_document()
std::string evaluation_page(const std::vector<EvaluationRow>& rows, const std::vector<Plot>& figures,
                            const std::string& setup, const std::string& made);

}  // namespace palpate
