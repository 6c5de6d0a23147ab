/// \file
/// Stages 1 and 2 of contact_kernel.h: tree traversal against the tool's box, and culling by bounding
/// spheres.
// clang-format off
#if defined(PALPATE_COLLISION_WALK_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_WALK_LANES_INL_H_
#undef PALPATE_COLLISION_WALK_LANES_INL_H_
#else
#define PALPATE_COLLISION_WALK_LANES_INL_H_
#endif
// clang-format on

#include <span>

#include <hwy/cache_control.h>

#include <palpate/collision/contact.h>
#include <palpate/collision/pair_buffer.h>
#include <palpate/collision/pair_lanes-inl.h>
#include <palpate/collision/tool_frame.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Loads lanes of a node or block, from slot i on.
struct From {
  std::size_t i;

  HWY_INLINE Floats operator()(const Lanes16<float>& lane) const {
    return Floats::load([&](std::size_t) HWY_ATTR { return &lane[i]; });
  }
  /// Loads integers reinterpreted as floats, only to be moved.
  HWY_INLINE Floats operator()(const Lanes16<std::uint32_t>& lane) const {
    return Floats(hn::BitCast(DFloat(), hn::Load(hn::Rebind<std::uint32_t, DFloat>(), &lane[i])));
  }
  HWY_INLINE Vec3<Floats> operator()(const std::array<Lanes16<float>, 3>& lanes) const {
    return {(*this)(lanes[0]), (*this)(lanes[1]), (*this)(lanes[2])};
  }
};

/// Pending nodes and blocks of a traversal. Lists are a whole vector longer than their maximum size, so that
/// whole vectors may be stored at their end.
struct Pending {
  /// Number of blocks from which they are processed: in small portions, so that their memory, which was
  /// prefetched when they were found, has arrived and is not yet evicted.
  static constexpr std::size_t kPortion = kIndexWidth;

  std::size_t node_count = 0, block_count = 0;
  std::uint32_t nodes[kMaxIndexStack + kIndexWidth];
  std::uint32_t blocks[kPortion + 2 * kIndexWidth];
};

/// True where the tool and the box [low, high] are certainly disjoint: where, in the frame in which the tool
/// is the unit sphere, a plane perpendicular to the line of centres separates the two. With m from the tool's
/// centre to the box's, h half the box's size and M = W^T W, that is where
///
///     m^T M m - |M m| . h  >  sqrt(m^T M m).
///
/// Here m and h are twice as long; the slack is derived in tool_frame.h. Of the boxes that overlap the tool's
/// own, which is twice as large as the tool, this separates a third.
HWY_INLINE LaneMask<DFloat, 1> is_apart(const Vec3<Floats>& low, const Vec3<Floats>& high,
                                        const ToolFrame& tool) {
  const Vec3<Floats> center = broadcast<Floats>(tool.center_high);
  const Vec3<Floats> from = low - center, to = high - center, m = from + to, h = to - from;
  const Vec3<Floats> g = broadcast<Floats>(tool.metric) * m;
  const Floats mm = dot(m, g), extent = fma(abs(g.x), h.x, fma(abs(g.y), h.y, abs(g.z) * h.z));
  const Floats size = squared_norm(m) + squared_norm(h);
  const Floats gap = (mm - extent) - fma(Floats(tool.box.per_square), size, Floats(tool.box.constant));
  return (gap > 0.0F) & (gap * gap > mm * 4.0F);
}

/// Gaussians at their original size.
struct AsTheyAre {
  HWY_INLINE void grow(Vec3<Floats>&, Vec3<Floats>&) const {}
  HWY_INLINE void grow(Vec3<Floats>&) const {}
};

/// Gaussians enlarged `times` times, each about its own centre. The contents of a box are then in the box
/// enlarged as many times about its centre, since no ellipsoid is larger than its box.
struct Magnified {
  float times;

  HWY_INLINE void grow(Vec3<Floats>& low, Vec3<Floats>& high) const {
    const Vec3<Floats> more = scaled(high - low, 0.5F * (times - 1.0F));
    low = low - more;
    high = high + more;
  }
  HWY_INLINE void grow(Vec3<Floats>& length) const { length = scaled(length, times); }

 private:
  HWY_INLINE static Vec3<Floats> scaled(const Vec3<Floats>& v, float s) {
    return {v.x * s, v.y * s, v.z * s};
  }
};

/// Appends the nodes and the blocks whose boxes overlap the tool's. Branchless: which slots overlap, and
/// which of them are blocks, cannot be predicted. \pre pending.block_count <= Pending::kPortion.
template <class Size>
HWY_INLINE void expand(const IndexNode& node, const ToolFrame& tool, const Size& size, Pending& pending) {
  const Vec3<Floats> low = broadcast<Floats>(tool.low), high = broadcast<Floats>(tool.high);
  for (std::size_t i = 0; i < kIndexWidth; i += Floats::width()) {
    const From from{i};
    Vec3<Floats> node_low = from(node.low), node_high = from(node.high);
    size.grow(node_low, node_high);
    const auto meets = (node_low.x <= high.x) & (node_low.y <= high.y) & (node_low.z <= high.z) &
                       (node_high.x >= low.x) & (node_high.y >= low.y) & (node_high.z >= low.z);
    const Floats child = from(node.child);
    const auto near = and_not(is_apart(node_low, node_high, tool), meets);
    const auto block = is_negative(child);  // IndexNode::kLeaf is the sign bit of a float
    const auto add = [&](const LaneMask<DFloat, 1>& which, std::uint32_t* list, std::size_t& count) HWY_ATTR {
      const LanePacker<DFloat> pack(which);
      pack(child, reinterpret_cast<float*>(list + count));
      count += count_of(which);
    };
    add(near & block, pending.blocks, pending.block_count);
    add(and_not(block, near), pending.nodes, pending.node_count);
  }
}

/// Prefetches all that cull() reads, so that its memory latencies overlap. No more than that: the processor
/// can only wait for a limited number of lines, and prefetches the others by itself.
HWY_INLINE void prefetch(const GaussianBlock& block) {
  for (const auto& lane : block.position) hwy::Prefetch(&lane);
  for (const auto& lane : block.length_high) hwy::Prefetch(&lane);
}

/// Appends to `out` the Gaussians that may touch the tool: |d'| <= 1 + length_max / a_min, paper eq. 4 in the
/// frame where the tool is a unit sphere, where it is sharper. \pre out.has_room_for_block(). \returns the
/// number of Gaussians in the block.
template <Precision kPrecision, class Size>
HWY_INLINE std::size_t cull(std::span<const GaussianBlock> blocks, std::uint32_t number,
                            const ToolFrame& tool, const Size& size, PairBuffer& out) {
  const GaussianBlock& block = blocks[number];
  const Matrix3<Floats> W = broadcast<Floats>(tool.W_float);
  const Vec3<Floats> high = broadcast<Floats>(tool.center_high), low = broadcast<Floats>(tool.center_low);
  const hn::Rebind<std::uint32_t, DFloat> numbers;
  std::size_t gaussians = 0;
  for (std::size_t i = 0; i < kIndexWidth; i += Floats::width()) {
    const From from{i};
    const Vec3<Floats> position = from(block.position);
    Vec3<Floats> length = from(block.length_high);
    size.grow(length);
    gaussians += count_of(is_number(position.x));
    const Floats distance_squared = squared_norm(W * ((high - position) + low));
    const Floats longest = max(length.x, max(length.y, length.z));
    const Floats reach = fma(longest, Floats(tool.reach_per_length), Floats(1.0F));
    const auto near = distance_squared <= reach * reach * (1.0F + tool.cull_slack);

    const LanePacker<DFloat> pack(near);
    const std::size_t n = out.size;
    const auto pack_all = [&](const auto& lanes, auto& to) HWY_ATTR {
      for (std::size_t k = 0; k < lanes.size(); ++k) pack(from(lanes[k]), &to[k][n]);
    };
    pack_all(block.position, out.position);
    pack(length.x, &out.length_high[0][n]);
    pack(length.y, &out.length_high[1][n]);
    pack(length.z, &out.length_high[2][n]);
    if constexpr (kPrecision == Precision::kDouble) pack_all(block.length_low, out.length_low);
    pack_all(block.rotation, out.rotation);
    const auto slots = hn::Iota(numbers, static_cast<std::uint32_t>(number * kIndexWidth + i));
    pack(Floats(hn::BitCast(DFloat(), slots)), reinterpret_cast<float*>(&out.slot[n]));
    out.size += count_of(near);
  }
  return gaussians;
}

/// Traverses the tree depth first from the state of `pending` and fills `buffer`, calling `flush(buffer)`,
/// which must empty it, whenever it is full, until that returns false, or `most` Gaussians and those of a few
/// more blocks have been visited. The caller processes what remains in it at the end. \pre `pending` has no
/// blocks; nor has it afterwards, unless `flush` returned false. \returns the number of Gaussians in the
/// blocks visited.
template <Precision kPrecision, class Size, class Flush>
HWY_INLINE std::size_t walk_on(const IndexView& index, const ToolFrame& tool, const Size& size,
                               std::size_t most, Pending& pending, PairBuffer& buffer, const Flush& flush) {
  std::size_t walked = 0;
  while (pending.node_count != 0 && walked < most) {
    const std::size_t blocks_before = pending.block_count;
    expand(index.nodes[pending.nodes[--pending.node_count]], tool, size, pending);
    for (std::size_t k = blocks_before; k < pending.block_count; ++k) {
      pending.blocks[k] &= ~IndexNode::kLeaf;
      prefetch(index.blocks[pending.blocks[k]]);
    }
    if (pending.node_count != 0) {
      hwy::Prefetch(&index.nodes[pending.nodes[pending.node_count - 1]]);
      if (pending.block_count < Pending::kPortion) continue;
    }
    for (std::size_t k = 0; k < pending.block_count; ++k) {
      if (!buffer.has_room_for_block() && !flush(buffer)) return walked;
      walked += cull<kPrecision>(index.blocks, pending.blocks[k], tool, size, buffer);
    }
    pending.block_count = 0;
  }
  return walked;
}

/// Traverses the whole tree.
template <Precision kPrecision, class Size, class Flush>
HWY_INLINE std::size_t walk(const IndexView& index, const ToolFrame& tool, const Size& size,
                            PairBuffer& buffer, const Flush& flush) {
  Pending pending;
  if (!index.nodes.empty()) pending.nodes[pending.node_count++] = 0;
  return walk_on<kPrecision>(index, tool, size, kAllPairs, pending, buffer, flush);
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
