/// \file
/// Report page of a recording.
#pragma once

#include <string>

namespace palpate::cli {

/// Report page of a recording file, without its scene; on failure, a page with the error message.
std::string recording_page(const std::string& csv);

}  // namespace palpate::cli
