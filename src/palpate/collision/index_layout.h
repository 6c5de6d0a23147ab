/// \file
/// Memory layout of a SceneIndex and its file: nodes and blocks.
///
/// A wide bounding volume hierarchy over ellipsoids. Every node has up to sixteen children, whose boxes are
/// tested together; every leaf is one self-contained block of sixteen Gaussians, so that a query reads
/// nothing else. Everything is in the captured frame, relative to IndexView::origin, independent of the
/// registration.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace palpate {

/// Children per node and Gaussians per block. Sixteen floats are one AVX-512 register and one cache line;
/// narrower instruction sets process them in two or four steps. Wider nodes test more distant boxes, narrower
/// ones wait for memory more often.
inline constexpr std::size_t kIndexWidth = 16;

/// One float or id for each of sixteen lanes: a cache line, and an AVX-512 vector.
template <typename T>
struct alignas(64) Lanes16 : std::array<T, kIndexWidth> {};

/// Sixteen boxes and their children. Boxes are closed and contain the ellipsoids below them despite rounding.
/// An unused slot has an empty box (low > high), which overlaps nothing.
struct alignas(64) IndexNode {
  std::array<Lanes16<float>, 3> low;   ///< by axis. Unit: [captured units].
  std::array<Lanes16<float>, 3> high;  ///< by axis
  Lanes16<std::uint32_t> child;        ///< a node, or a block if kLeaf is set

  static constexpr std::uint32_t kLeaf = 1U << 31;
};
static_assert(sizeof(IndexNode) == 448, "seven cache lines; part of the file format");

/// Sixteen Gaussians as ellipsoids. Positions and quaternions are the floats of the scene file; lengths and
/// opacities, which are derived from its numbers, are sums of two floats, accurate to 2^-48: contacts then
/// differ from those of the file's own numbers by 1e-14, and a query needs no exponential. An unused lane has
/// a position of NaN, which fails every proximity test. Lanes are in increasing order of id.
struct alignas(64) GaussianBlock {
  std::array<Lanes16<float>, 3> position;     ///< relative to the origin
  std::array<Lanes16<float>, 3> length_high;  ///< of the semi-axes, k sigma; high part
  std::array<Lanes16<float>, 3> length_low;   ///< low part
  std::array<Lanes16<float>, 4> rotation;     ///< w x y z, not normalised
  Lanes16<float> opacity_high;                ///< alpha
  Lanes16<float> opacity_low;
  Lanes16<std::uint32_t> id;  ///< row in the scene file
};
static_assert(sizeof(GaussianBlock) == 64 * kIndexWidth, "64 bytes a Gaussian; part of the file format");

/// Maximum depth of a tree that is built or accepted. From half of that on, the builder stops optimising
/// splits and halves instead; 2^32 Gaussians take 28 halvings.
inline constexpr std::uint32_t kMaxIndexDepth = 64;

/// Maximum number of blocks, so that 32 bits encode block and lane of a Gaussian: room for 2^32 Gaussians.
inline constexpr std::size_t kMaxIndexBlocks = (std::size_t{1} << 32) / kIndexWidth;

/// Maximum stack size of a depth-first traversal.
inline constexpr std::size_t kMaxIndexStack = kMaxIndexDepth * (kIndexWidth - 1) + 1;

/// Non-owning view of an index.
struct IndexView {
  std::span<const IndexNode> nodes;       ///< the root first; none if nothing is solid
  std::span<const GaussianBlock> blocks;  ///< in the order of the leaves
  std::uint64_t gaussians = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< captured frame
};

}  // namespace palpate
