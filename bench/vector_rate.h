/// \file
/// Peak arithmetic rate of the processor.
#pragma once

#include <string>

namespace palpate::bench {

struct VectorRate {
  std::string target;       ///< Highway's name of the instruction set
  double lanes_per_second;  ///< single-precision operations per second and core; a multiply-add counts as one
};

/// Measures the rate of independent multiply-adds on registers with the best instruction set; the best of
/// several tries.
VectorRate measure_vector_rate();

}  // namespace palpate::bench
