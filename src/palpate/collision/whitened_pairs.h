/// \file
/// Pairs on their way through the last stages of the contact kernel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/pair_buffer.h>

namespace palpate {

/// Pairs as the tool sees them, where it is the unit sphere, and what is found out about them: eight in
/// double or sixteen in single precision, so that each number of theirs takes a cache line, and a vector of
/// AVX-512. Together, and not as one long array a number, since arrays whose addresses differ by a multiple
/// of 4096 get in each other's way.
template <typename T>
struct alignas(64) WhitenedGroup {
  static constexpr std::size_t kWidth = 64 / sizeof(T);
  using Lane = std::array<T, kWidth>;

  std::array<Lane, 3> distance;  ///< d'
  std::array<Lane, 9> l;         ///< columns of L
  std::array<Lane, 6> k;         ///< KFunction: p0 p1 p2 e1 e2 e3
  Lane opacity;
  Lane t;      ///< lambda / (1 - lambda): where to look for the minimum of K, then where it is
  Lane k_min;  ///< there

  // What follows from where the minimum is, see Contact; points relative to the tool's centre.
  Lane lambda, depth;
  std::array<Lane, 3> center, point, normal;
};

/// The work on pairs is done in rounds, each over all of them before the next: while one vector waits for a
/// division, the processor is busy with the others.
template <typename T>
struct WhitenedPairs {
  using Group = WhitenedGroup<T>;
  static constexpr std::size_t kCapacity = PairBuffer::kCapacity;
  static constexpr std::size_t kWidth = Group::kWidth;
  /// For each group, one bit a pair.
  using Bits = std::array<std::uint32_t, kCapacity / kWidth>;

  std::array<Group, kCapacity / kWidth> groups;
  Bits open;  ///< it may touch
  Bits sure;  ///< it does, with K_min as it is

  Group& group(std::size_t pair) { return groups[pair / kWidth]; }
  const Group& group(std::size_t pair) const { return groups[pair / kWidth]; }
  bool is_open(std::size_t pair) const { return (open[pair / kWidth] >> (pair % kWidth) & 1U) != 0; }
};

}  // namespace palpate
