/// \file
/// Runs as pages.
#pragma once

#include <string>

#include <palpate/record/run_log.h>

namespace palpate::cli {

/// The report page of a run, without its scene. \param title text
std::string report_document(const Run& run, const std::string& title);

}  // namespace palpate::cli
