/// \file
/// Random numbers as a pure function of a seed and an index.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace palpate::bench {

/// Purpose of a stream of random numbers: different purposes have different streams.
enum class Purpose : std::uint64_t { kGaussian, kCell, kPose, kOrder };

/// A short stream per (seed, purpose, index), by splitmix64 (Steele, Lea and Flood 2014). Unlike Random,
/// whose engine has 2.5 KB of state to initialise, it is cheap to construct: one for each of 100 million
/// Gaussians.
class HashRandom {
 public:
  HashRandom(std::uint64_t seed, Purpose purpose, std::uint64_t index)
      : state_(mix(mix(mix(seed) + static_cast<std::uint64_t>(purpose)) + index)) {}

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() {
    state_ += 0x9e3779b97f4a7c15U;  // 2^64 / golden ratio, odd: visits all 2^64 states
    return static_cast<double>(mix(state_) >> 11) * 0x1p-53;
  }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Log-uniform in [low, high). \pre both are positive.
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform()); }
  /// Uniform in 0 ... n-1. \pre 0 < n < 2^53.
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
  /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  /// Finalizer of splitmix64: a bijection in which every input bit flips every output bit half the time.
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace palpate::bench
