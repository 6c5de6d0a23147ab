/// \file
/// What figures were measured on.
#pragma once

#include <string>

namespace palpate::bench {

/// Where and when: processor, cores, compiler, date (UTC). One line.
std::string machine();

}  // namespace palpate::bench
