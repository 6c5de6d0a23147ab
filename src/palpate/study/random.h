/// \file
/// Platform-independent random numbers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>

namespace palpate {

/// A stream of random numbers that depends on its seed only. The standard specifies what std::mt19937_64
/// produces but leaves its distributions to each library, so the transforms are implemented here. Only the
/// last bit of log and cos in normal() depends on the platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform in 0 ... n-1. \pre 0 < n < 2^53.
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }

  /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958; always draws two uniforms).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace palpate
