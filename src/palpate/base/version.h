/// \file
/// Version of the library and the program.
#pragma once

#include <string_view>

namespace palpate {

/// "0.1.0", as defined in CMake.
std::string_view version();

}  // namespace palpate
