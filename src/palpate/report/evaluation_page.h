/// \file
/// Figures and page of an evaluation against analytic surfaces.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/evaluation_table.h>
#include <palpate/report/plot.h>

namespace palpate {

/// Figures of all rows or, where that is too many, of the first shape and spacing. \pre rows is not empty.
/// \param stiffness nominal stiffness of the models proxy and field. Unit: [N/m].
std::vector<Plot> evaluation_figures(const std::vector<EvaluationRow>& rows, double stiffness);

/// Returns a self-contained HTML page. \param setup a sentence that describes the experiment \param made see
/// page_document()
std::string evaluation_page(const std::vector<EvaluationRow>& rows, const std::vector<Plot>& figures,
                            const std::string& setup, const std::string& made);

}  // namespace palpate
