/// \file
/// Selection of the instruction set of the contact query. The best is used by default; tests and benchmarks
/// select others.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Instruction sets that this build contains and this processor supports, best first, by Highway's names:
/// "AVX3" (AVX-512), "AVX2", "SSE4", "NEON", and "SCALAR" (or "EMU128"), which every processor supports.
std::vector<std::string> simd_targets();

/// Selects `name`, one of simd_targets(), from the next query on, in all threads; the best one if it is
/// empty. Must not be called while queries run.
void use_simd_target(std::string_view name);

}  // namespace palpate
