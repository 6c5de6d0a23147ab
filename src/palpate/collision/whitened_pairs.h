/// \file
/// Pairs in the later stages of the contact kernel, in the frame where the tool is the unit sphere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/pair_buffer.h>

namespace palpate {

/// One bit per pair.
struct PairBits {
  static constexpr std::size_t kWidth = 32;
  std::array<std::uint32_t, PairBuffer::kCapacity / kWidth + 1> words;

  bool operator[](std::size_t pair) const { return (words[pair / kWidth] >> (pair % kWidth) & 1U) != 0; }
};

/// Pairs in the frame where the tool is the unit sphere, with intermediate results. Each step is done for all
/// pairs before the next, which hides latencies: while one vector waits for a division, the processor works
/// on others.
template <typename T>
struct WhitenedPairs {
  static constexpr std::size_t kCapacity = PairBuffer::kCapacity;
  template <typename Number>
  using Lane = PairBuffer::Lane<Number>;

  alignas(64) std::array<Lane<T>, 3> distance;  ///< d'
  alignas(64) std::array<Lane<T>, 9> l;         ///< columns of L
  alignas(64) std::array<Lane<T>, 6> k;         ///< KFunction: p0 p1 p2 e1 e2 e3
  alignas(64) Lane<T> t;                        ///< lambda / (1 - lambda): initial guess, then argmin of K
  alignas(64) Lane<T> k_min;                    ///< minimum of K
  PairBits open;                                ///< may touch
  PairBits sure;                                ///< certainly touches, and k_min is final

  /// Results at the minimum, in the world frame, in pairs of numbers as laid out in Contact: k_min and
  /// lambda; centre x and y; centre z and point x; point y and z; normal x and y; normal z and depth.
  alignas(64) std::array<Lane<std::array<double, 2>>, 6> row;
};

}  // namespace palpate
