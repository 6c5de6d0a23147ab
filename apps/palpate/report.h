/// \file
/// Report page of a recording.
#pragma once

#include <string>

namespace palpate::cli {

/// The report page of the recording in a file, without its scene; a page that says why if it cannot be made.
std::string recording_page(const std::string& csv);

}  // namespace palpate::cli
