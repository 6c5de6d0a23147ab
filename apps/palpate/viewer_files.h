/// \file
/// Files of the viewer, embedded in the program.
#pragma once

#include <string_view>

#include <palpate/live/live_gateway.h>

namespace palpate::cli {

/// The file of that path; null if the viewer has none.
const WebFile* viewer_file(std::string_view path);

}  // namespace palpate::cli
