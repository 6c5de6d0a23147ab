/// \file
/// Which instruction set the contact query runs on. The best is taken by itself; tests and benchmarks choose.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// The instruction sets that this build has and this processor runs, best first, by Highway's names: "AVX3"
/// (AVX-512), "AVX2", "SSE4", "NEON", and "SCALAR" (or "EMU128"), which every processor runs.
std::vector<std::string> simd_targets();

/// Takes `name`, one of simd_targets(), from the next query on, in all threads; the best one if it is empty.
/// Not for use while queries run.
void use_simd_target(std::string_view name);

}  // namespace palpate
