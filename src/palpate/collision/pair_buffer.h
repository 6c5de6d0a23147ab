/// \file
/// Batch buffer of potentially touching pairs between the stages of the contact kernel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/index_layout.h>

namespace palpate {

/// Position of a Gaussian in an index: block and lane.
struct GaussianSlot {
  std::uint32_t number;  ///< kIndexWidth times the block, plus the lane

  std::size_t block() const { return number / kIndexWidth; }
  std::size_t lane() const { return number % kIndexWidth; }
};

/// Gaussians that passed the cull, as stored in their blocks.
struct PairBuffer {
  /// Batch size of the later stages: small, since with the intermediate results of those stages a batch takes
  /// 40 KB, a first-level cache, yet large enough to hide latencies.
  static constexpr std::size_t kCapacity = 192;

  template <typename T>
  using Lane = std::array<T, kCapacity + kIndexWidth>;  // padding for whole-vector stores at the end

  std::size_t size = 0;
  alignas(64) std::array<Lane<float>, 3> position;
  alignas(64) std::array<Lane<float>, 3> length_high;
  alignas(64) std::array<Lane<float>, 3> length_low;  ///< for Precision::kDouble only
  alignas(64) std::array<Lane<float>, 4> rotation;
  alignas(64) Lane<GaussianSlot> slot;
  alignas(64) Lane<float> extent;  ///< extent_of() the Gaussian, set from the screening on

  bool has_room_for_block() const { return size + kIndexWidth <= kCapacity; }
};

}  // namespace palpate
