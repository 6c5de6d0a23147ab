/// \file
/// Figures and page of stability trials.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/plot.h>
#include <palpate/report/stability_table.h>

namespace palpate {

/// A hand that rests and slides, felt through one of the sources.
struct StabilityTrace {
  std::string name;
  std::vector<StabilityTick> ticks;
};

/// \param traces of one device, hand and model, told by `trace_subtitle`
std::vector<Plot> stability_figures(const StabilityTables& tables, const std::vector<StabilityTrace>& traces,
                                    const std::string& trace_subtitle);

/// A whole page that needs no network. `setup` says in a sentence what was done. \param made see
/// page_document()
std::string stability_page(const StabilityTables& tables, const std::vector<Plot>& figures,
                           const std::string& setup, const std::string& made);

}  // namespace palpate
