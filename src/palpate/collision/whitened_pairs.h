/// \file
/// Pairs on their way through the last stages of the contact kernel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/pair_buffer.h>

namespace palpate {

/// One bit a pair.
struct PairBits {
  static constexpr std::size_t kWidth = 32;
  std::array<std::uint32_t, PairBuffer::kCapacity / kWidth + 1> words;

  bool operator[](std::size_t pair) const { return (words[pair / kWidth] >> (pair % kWidth) & 1U) != 0; }
};

/// Pairs as the tool sees them, where it is the unit sphere, and what is found out about them. The work on
/// them is done in rounds, each over all of them before the next: while one vector waits for a division, the
/// processor is busy with the others.
template <typename T>
struct WhitenedPairs {
  static constexpr std::size_t kCapacity = PairBuffer::kCapacity;
  template <typename Number>
  using Lane = PairBuffer::Lane<Number>;

  alignas(64) std::array<Lane<T>, 3> distance;  ///< d'
  alignas(64) std::array<Lane<T>, 9> l;         ///< columns of L
  alignas(64) std::array<Lane<T>, 6> k;         ///< KFunction: p0 p1 p2 e1 e2 e3
  alignas(64) Lane<T> t;      ///< lambda / (1 - lambda): where to look for the minimum of K, then where it is
  alignas(64) Lane<T> k_min;  ///< there
  PairBits open;              ///< it may touch
  PairBits sure;              ///< it does, with K_min as it is

  /// What follows from where the minimum is, in the world frame, two numbers at a time as Contact has them:
  /// k_min and lambda; centre x and y; centre z and point x; point y and z; normal x and y; normal z and
  /// depth.
  alignas(64) std::array<Lane<std::array<double, 2>>, 6> row;
};

}  // namespace palpate
