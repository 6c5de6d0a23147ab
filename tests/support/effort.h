/// \file
/// How much a test that draws at random does.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace palpate::test {

#if defined(PALPATE_UNDER_SANITIZER) || defined(PALPATE_EMULATED)
inline constexpr std::size_t kSlowdown = 10;
#else
inline constexpr std::size_t kSlowdown = 1;
#endif

/// `full` draws; a tenth of that, and at least one, where code takes ten times as long: instrumented, or on
/// an emulated processor.
constexpr std::size_t draws(std::size_t full) { return std::max<std::size_t>(1, full / kSlowdown); }

/// Whether `./test --long` asks for the long version of a test, where code is not slow.
inline bool is_long() { return kSlowdown == 1 && std::getenv("PALPATE_LONG") != nullptr; }

}  // namespace palpate::test
