/// \file
/// Summary of a run, as text and JSON.
#pragma once

#include <string>
#include <vector>

#include <palpate/record/run_log.h>
#include <palpate/report/ordered_json.h>

namespace palpate {

OrderedJson run_json(const std::vector<RunRow>& rows);

/// Lists the contact episodes, as many as fit a screen, and summarizes the run.
std::string run_text(const std::vector<RunRow>& rows);

}  // namespace palpate
