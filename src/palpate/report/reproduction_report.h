/// \file
/// Tables, figures and page of a reproduction of the paper's evaluation.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/ordered_json.h>
#include <palpate/report/plot.h>
#include <palpate/study/reproduction_claims.h>

namespace palpate {

/// All results of a reproduction.
struct ReproductionResult {
  std::string setup;  ///< description of the experiment, in a few sentences
  std::vector<Claim> claims;
  RoomPath path;
  /// First the paper's pipeline and force, then the project's defaults, both on the admittance device; then
  /// all others.
  std::vector<ReproductionRun> runs;
};

std::string reproduction_text(const ReproductionResult& result);
OrderedJson reproduction_json(const ReproductionResult& result);
/// Returns every tick of the first two runs.
std::string reproduction_csv(const ReproductionResult& result);

/// Plots the paper's Fig. 4, from above and from the side, and the four rows of its Fig. 5 for the first two
/// runs. \param scene of which some centres are drawn
std::vector<Plot> reproduction_figures(const ReproductionResult& result, const EllipsoidScene& scene);

/// \param made see page_document()
std::string reproduction_page(const ReproductionResult& result, const std::vector<Plot>& figures,
                              const std::string& made);

}  // namespace palpate
