/// \file
/// Figures and page of stability trials.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/plot.h>
#include <palpate/report/stability_table.h>

namespace palpate {

/// Trial in which a hand rests and slides, with one source of contacts.
struct StabilityTrace {
  std::string name;
  std::vector<StabilityTick> ticks;
};

/// Repeats the trials of the first profile and model with the middle hand at the first place, one per contact
/// source. \param subtitle set to their device, model and hand
std::vector<StabilityTrace> stability_traces(const StabilityStudy& study, const StabilityTables& tables,
                                             std::string& subtitle);

/// \param traces of one device, hand and model, which `trace_subtitle` names
std::vector<Plot> stability_figures(const StabilityTables& tables, const std::vector<StabilityTrace>& traces,
                                    const std::string& trace_subtitle);

/// Returns a self-contained HTML page. \param setup a sentence that describes the experiment \param made see
/// page_document()
std::string stability_page(const StabilityTables& tables, const std::vector<Plot>& figures,
                           const std::string& setup, const std::string& made);

}  // namespace palpate
