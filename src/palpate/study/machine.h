/// \file
/// Description of the machine that figures were measured on.
#pragma once

#include <string>

namespace palpate {

/// Returns processor, cores, compiler and date (UTC) in one line.
std::string machine();

}  // namespace palpate
