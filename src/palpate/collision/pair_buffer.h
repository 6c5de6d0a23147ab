/// \file
/// Between the stages of the contact kernel: pairs that might touch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/index_layout.h>

namespace palpate {

/// Where a Gaussian is in an index: its block, and in that its lane.
struct GaussianSlot {
  std::uint32_t number;  ///< kIndexWidth times the block, plus the lane

  std::size_t block() const { return number / kIndexWidth; }
  std::size_t lane() const { return number % kIndexWidth; }
};

/// Gaussians that passed the cull, as their blocks have them.
struct PairBuffer {
  /// Pairs that are taken through the later stages at once: as few as keep a processor busy while some wait,
  /// since with what the later stages find out about them they take 40 KB, a first-level cache.
  static constexpr std::size_t kCapacity = 192;

  template <typename T>
  using Lane = std::array<T, kCapacity + kIndexWidth>;  // so that whole vectors may be stored at the end

  std::size_t size = 0;
  alignas(64) std::array<Lane<float>, 3> position;
  alignas(64) std::array<Lane<float>, 3> length_high;
  alignas(64) std::array<Lane<float>, 3> length_low;  ///< for Precision::kDouble only
  alignas(64) std::array<Lane<float>, 4> rotation;
  alignas(64) Lane<GaussianSlot> slot;
  alignas(64) Lane<float> extent;  ///< extent_of() the Gaussian, from the screen on

  bool has_room_for_block() const { return size + kIndexWidth <= kCapacity; }
};

}  // namespace palpate
