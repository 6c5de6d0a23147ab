/// \file
/// How fast the processor computes where nothing holds it up.
#pragma once

#include <string>

namespace palpate::bench {

struct VectorRate {
  std::string target;       ///< Highway's name of the instruction set
  double lanes_per_second;  ///< operations a second on single-precision lanes, one core, a multiply-add being
                            ///< one
};

/// Of the best instruction set: the rate of independent multiply-adds on registers, best of several tries.
VectorRate measure_vector_rate();

}  // namespace palpate::bench
