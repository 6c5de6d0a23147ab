/// \file
/// Stages 1 and 2 of contact_kernel.h: the tree against the tool's box, a block's bounding spheres against
/// the tool.
// clang-format off
#if defined(PALPATE_COLLISION_WALK_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_WALK_LANES_INL_H_
#undef PALPATE_COLLISION_WALK_LANES_INL_H_
#else
#define PALPATE_COLLISION_WALK_LANES_INL_H_
#endif
// clang-format on

#include <hwy/cache_control.h>

#include <palpate/collision/pair_buffer.h>
#include <palpate/collision/pair_lanes-inl.h>
#include <palpate/collision/tool_frame.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Loads from the lanes of a node or block, from slot i on.
struct From {
  std::size_t i;

  HWY_INLINE Floats operator()(const Lanes16<float>& lane) const {
    return Floats::load([&](std::size_t) HWY_ATTR { return &lane[i]; });
  }
  /// As floats, whose bits they are not: to be moved only.
  HWY_INLINE Floats operator()(const Lanes16<std::uint32_t>& lane) const {
    return Floats(hn::BitCast(DFloat(), hn::Load(hn::Rebind<std::uint32_t, DFloat>(), &lane[i])));
  }
  HWY_INLINE Vec3<Floats> operator()(const std::array<Lanes16<float>, 3>& lanes) const {
    return {(*this)(lanes[0]), (*this)(lanes[1]), (*this)(lanes[2])};
  }
};

/// What a walk has come upon and not dealt with yet. Lists are longer than they can get by a whole vector,
/// which may be stored at their end.
struct Pending {
  /// Blocks are dealt with when there are at least so many: in small portions, so that their memory, which
  /// was asked for when they were found, is there, and not gone again.
  static constexpr std::size_t kPortion = kIndexWidth;

  std::size_t node_count = 0, block_count = 0;
  std::uint32_t nodes[kMaxIndexStack + kIndexWidth];
  std::uint32_t blocks[kPortion + 2 * kIndexWidth];
};

/// Appends the nodes and the blocks whose boxes meet the tool's. Without a branch: which slots meet, and
/// which of them are blocks, is nothing that a processor could predict. \pre pending.block_count <=
/// Pending::kPortion.
HWY_INLINE void expand(const IndexNode& node, const ToolFrame& tool, Pending& pending) {
  const Vec3<Floats> low = broadcast<Floats>(tool.low), high = broadcast<Floats>(tool.high);
  for (std::size_t i = 0; i < kIndexWidth; i += Floats::width()) {
    const From from{i};
    const Vec3<Floats> node_low = from(node.low), node_high = from(node.high);
    const auto meets = (node_low.x <= high.x) & (node_low.y <= high.y) & (node_low.z <= high.z) &
                       (node_high.x >= low.x) & (node_high.y >= low.y) & (node_high.z >= low.z);
    const Floats child = from(node.child);
    const auto block = is_negative(child);  // IndexNode::kLeaf is where a float has its sign
    const auto add = [&](const LaneMask<DFloat, 1>& which, std::uint32_t* list, std::size_t& count) HWY_ATTR {
      const LanePacker<DFloat> pack(which);
      pack(child, reinterpret_cast<float*>(list + count));
      count += count_of(which);
    };
    add(meets & block, pending.blocks, pending.block_count);
    add(and_not(block, meets), pending.nodes, pending.node_count);
  }
}

/// Asks for all cache lines of `block` at once, so that the wait for memory is one.
HWY_INLINE void prefetch(const GaussianBlock& block) {
  constexpr std::size_t kLine = 64;
  const auto* bytes = reinterpret_cast<const char*>(&block);
  for (std::size_t k = 0; k < sizeof(GaussianBlock); k += kLine) hwy::Prefetch(bytes + k);
}

/// Appends to `out` what may touch the tool: |d'| <= 1 + length_max / a_min, paper eq. 4 in the frame where
/// the tool is a unit sphere, where it says more. \pre out.has_room_for_block(). \returns Gaussians in the
/// block.
HWY_INLINE std::size_t cull(const GaussianBlock& block, const ToolFrame& tool, PairBuffer& out) {
  const Matrix3<Floats> W = broadcast<Floats>(tool.W_float);
  const Vec3<Floats> high = broadcast<Floats>(tool.center_high), low = broadcast<Floats>(tool.center_low);
  std::size_t gaussians = 0;
  for (std::size_t i = 0; i < kIndexWidth; i += Floats::width()) {
    const From from{i};
    const Vec3<Floats> position = from(block.position), length = from(block.length_high);
    gaussians += count_of(is_number(position.x));
    const Floats distance_squared = squared_norm(W * ((high - position) + low));
    const Floats longest = max(length.x, max(length.y, length.z));
    const Floats reach = fma(longest, Floats(tool.reach_per_length), Floats(1.0F));
    const auto near = distance_squared <= reach * reach * (1.0F + tool.cull_slack);

    const LanePacker<DFloat> pack(near);
    const std::size_t n = out.size;
    for (std::size_t k = 0; k < 3; ++k) pack(from(block.position[k]), &out.position[k][n]);
    for (std::size_t k = 0; k < 3; ++k) pack(from(block.length_high[k]), &out.length_high[k][n]);
    for (std::size_t k = 0; k < 3; ++k) pack(from(block.length_low[k]), &out.length_low[k][n]);
    for (std::size_t k = 0; k < 4; ++k) pack(from(block.rotation[k]), &out.rotation[k][n]);
    pack(from(block.opacity_high), &out.opacity_high[n]);
    pack(from(block.opacity_low), &out.opacity_low[n]);
    pack(from(block.id), reinterpret_cast<float*>(&out.id[n]));
    out.size += count_of(near);
  }
  return gaussians;
}

/// Walks the tree depth first and fills `buffer`, calling `flush(buffer)`, which must empty it, whenever it
/// is full. What is left in it at the end is the caller's. \returns the Gaussians in the blocks that were
/// met.
template <class Flush>
HWY_INLINE std::size_t walk(const IndexView& index, const ToolFrame& tool, PairBuffer& buffer,
                            const Flush& flush) {
  std::size_t walked = 0;
  Pending pending;
  if (!index.nodes.empty()) pending.nodes[pending.node_count++] = 0;
  while (pending.node_count != 0) {
    const std::size_t blocks_before = pending.block_count;
    expand(index.nodes[pending.nodes[--pending.node_count]], tool, pending);
    for (std::size_t k = blocks_before; k < pending.block_count; ++k) {
      pending.blocks[k] &= ~IndexNode::kLeaf;
      prefetch(index.blocks[pending.blocks[k]]);
    }
    if (pending.node_count != 0) {
      hwy::Prefetch(&index.nodes[pending.nodes[pending.node_count - 1]]);
      if (pending.block_count < Pending::kPortion) continue;
    }
    for (std::size_t k = 0; k < pending.block_count; ++k) {
      if (!buffer.has_room_for_block()) flush(buffer);
      walked += cull(index.blocks[pending.blocks[k]], tool, buffer);
    }
    pending.block_count = 0;
  }
  return walked;
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
