/// \file
/// Files of the viewer, embedded in the program.
#pragma once

#include <string_view>

#include <palpate/live/live_gateway.h>

namespace palpate::cli {

/// Returns the file at `path`; null if there is none.
const WebFile* viewer_file(std::string_view path);

}  // namespace palpate::cli
