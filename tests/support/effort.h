/// \file
/// How much a test that draws at random does.
#pragma once

#include <cstddef>

namespace palpate::test {

#ifdef PALPATE_UNDER_SANITIZER
inline constexpr std::size_t kSlowdown = 10;
#else
inline constexpr std::size_t kSlowdown = 1;
#endif

/// `full` draws; a tenth of that where instrumented code takes ten times as long.
constexpr std::size_t draws(std::size_t full) { return full / kSlowdown; }

}  // namespace palpate::test
