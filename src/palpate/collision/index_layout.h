/// \file
/// The memory of a SceneIndex, which is also what its file holds: nodes and blocks, nothing else.
///
/// A wide bounding volume hierarchy over ellipsoids. Every node has up to sixteen children, whose boxes are
/// tested together; every leaf is one block of sixteen Gaussians, whole, so that a query reads nothing else.
/// All of it is in the captured frame, relative to IndexView::origin, whatever the registration.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace palpate {

/// Children of a node and Gaussians of a block. Sixteen floats are one AVX-512 register and one cache line;
/// narrower targets take them in two or four steps. Wider nodes test more boxes that are far away, narrower
/// ones wait for memory more often.
inline constexpr std::size_t kIndexWidth = 16;

/// One float or id for each of sixteen neighbours: a cache line, and a vector of AVX-512.
template <typename T>
struct alignas(64) Lanes16 : std::array<T, kIndexWidth> {};

/// Sixteen boxes and where they lead. Boxes are closed, and contain the ellipsoids below them whatever the
/// rounding. A slot without a child has an empty box (low > high), which nothing meets.
struct alignas(64) IndexNode {
  std::array<Lanes16<float>, 3> low;   ///< by axis. Unit: [captured units].
  std::array<Lanes16<float>, 3> high;  ///< by axis
  Lanes16<std::uint32_t> child;        ///< a node, or a block if kLeaf is set

  static constexpr std::uint32_t kLeaf = 1U << 31;
};
static_assert(sizeof(IndexNode) == 448, "seven cache lines; part of the file format");

/// Sixteen Gaussians as ellipsoids. Positions and quaternions are the floats of the scene file; lengths and
/// opacities, which are functions of its numbers, are sums of two floats, good to 2^-48: contacts then differ
/// from those of the file's own numbers by 1e-14, and a query needs no exponential. A lane without a Gaussian
/// has a position of NaN, which is near nothing. Lanes are in increasing order of id.
struct alignas(64) GaussianBlock {
  std::array<Lanes16<float>, 3> position;     ///< relative to the origin
  std::array<Lanes16<float>, 3> length_high;  ///< of the semi-axes, k sigma; the larger part
  std::array<Lanes16<float>, 3> length_low;   ///< and what is missing
  std::array<Lanes16<float>, 4> rotation;     ///< w x y z, not normalised
  Lanes16<float> opacity_high;                ///< alpha
  Lanes16<float> opacity_low;
  Lanes16<std::uint32_t> id;  ///< row in the scene file
};
static_assert(sizeof(GaussianBlock) == 64 * kIndexWidth, "64 bytes a Gaussian; part of the file format");

/// The deepest tree that is built or accepted. The builder stops looking for good splits at half of that, and
/// from there halves; 2^32 Gaussians take 28 halvings.
inline constexpr std::uint32_t kMaxIndexDepth = 64;

/// The most blocks, so that 32 bits tell a Gaussian's block and lane: room for 2^32 Gaussians.
inline constexpr std::size_t kMaxIndexBlocks = (std::size_t{1} << 32) / kIndexWidth;

/// Nodes that a depth-first walk may have to come back to.
inline constexpr std::size_t kMaxIndexStack = kMaxIndexDepth * (kIndexWidth - 1) + 1;

/// An index as the query sees it: memory that someone else owns.
struct IndexView {
  std::span<const IndexNode> nodes;       ///< the root first; none if nothing is solid
  std::span<const GaussianBlock> blocks;  ///< in the order of the leaves
  std::uint64_t gaussians = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< captured frame
};

}  // namespace palpate
