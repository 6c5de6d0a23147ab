/// \file
/// Description of the machine that figures were measured on.
#pragma once

#include <string>

namespace palpate {

/// Where and when: processor, cores, compiler, date (UTC). One line.
std::string machine();

}  // namespace palpate
