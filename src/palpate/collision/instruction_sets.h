/// \file
/// Instruction sets that the kernels are compiled for. Include before Highway.
#pragma once

// AVX-512 ("AVX3"), AVX2, SSE4, NEON, and the portable baseline, one lane of plain C++. Left out is what
// differs from its neighbour only in instructions that are not used here, and vectors whose length is not
// known when compiling.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE_256 | HWY_SVE2 | HWY_SVE2_128 | HWY_RVV | HWY_WASM_EMU256)
