/// \file
/// Load and store of WhitenedPairs between memory and lanes.
// clang-format off
#if defined(PALPATE_COLLISION_GROUP_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_GROUP_LANES_INL_H_
#undef PALPATE_COLLISION_GROUP_LANES_INL_H_
#else
#define PALPATE_COLLISION_GROUP_LANES_INL_H_
#endif
// clang-format on

#include <algorithm>
#include <cstdint>

#include <palpate/collision/pair_lanes-inl.h>
#include <palpate/collision/tool_frame.h>
#include <palpate/collision/whitened_pairs.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class L>
using PairsOf = WhitenedPairs<typename L::T>;

/// Loads one number per lane of L, from index i on.
template <class L>
HWY_INLINE L load(const PairBuffer::Lane<typename L::T>& lane, std::size_t i) {
  return L::load([&](std::size_t j) HWY_ATTR { return &lane[i + j * L::width()]; });
}
template <class L>
HWY_INLINE void store(const L& x, PairBuffer::Lane<typename L::T>& lane, std::size_t i) {
  x.store([&](std::size_t j) HWY_ATTR { return &lane[i + j * L::width()]; });
}

/// Loads a vector from three arrays, the first of them lanes[first].
template <class L, class Lanes3>
HWY_INLINE Vec3<L> load3(const Lanes3& lanes, std::size_t i, std::size_t first = 0) {
  return {load<L>(lanes[first], i), load<L>(lanes[first + 1], i), load<L>(lanes[first + 2], i)};
}

template <class L>
HWY_INLINE KLanes<L> load_k(const PairsOf<L>& pairs, std::size_t i) {
  return {load3<L>(pairs.k, i, 0), load3<L>(pairs.k, i, 3)};
}

/// A mask with one set bit per lane of L.
template <class L>
HWY_INLINE std::uint32_t lanes_mask() {
  return static_cast<std::uint32_t>((std::uint64_t{1} << (L::kVectors * L::width())) - 1);
}

/// The bits of the pairs in the lanes of L from i on, the first in bit 0.
template <class L>
HWY_INLINE std::uint32_t get_bits(const PairBits& bits, std::size_t i) {
  return bits.words[i / PairBits::kWidth] >> (i % PairBits::kWidth) & lanes_mask<L>();
}
template <class L>
HWY_INLINE void set_bits(PairBits& bits, std::size_t i, std::uint32_t value) {
  std::uint32_t& word = bits.words[i / PairBits::kWidth];
  const std::size_t shift = i % PairBits::kWidth;
  word = (word & ~(lanes_mask<L>() << shift)) | value << shift;
}

/// Sets exactly the first `n` bits.
HWY_INLINE void set_first(PairBits& bits, std::size_t n) {
  for (std::size_t i = 0; i < PairBuffer::kCapacity; i += PairBits::kWidth) {
    const std::size_t here = n <= i ? 0 : std::min(PairBits::kWidth, n - i);
    bits.words[i / PairBits::kWidth] = static_cast<std::uint32_t>((std::uint64_t{1} << here) - 1);
  }
}

/// A Gaussian in the frame where the tool is the unit sphere.
template <class L>
struct Whitened {
  Vec3<L> distance;
  Vec3<L> l[3];
  KLanes<L> k;

  /// \param offset from its centre to the tool's, captured frame
  template <class Matrix>
  HWY_INLINE Whitened(const Vec3<L>& offset, const Vec3<L> (&axis)[3], const Matrix& tool_W) {
    const Matrix3<L> W = broadcast<L>(tool_W);
    distance = W * offset;
    for (std::size_t c = 0; c < 3; ++c) l[c] = W * axis[c];
    k = k_function(distance, l);
  }

  /// Calls put(lane, numbers) for each array of WhitenedPairs that stores part of it.
  template <class Put>
  HWY_INLINE void put_into(PairsOf<L>& pairs, const Put& put) const {
    const auto put3 = [&](const Vec3<L>& v, auto* lanes) HWY_ATTR {
      put(lanes[0], v.x);
      put(lanes[1], v.y);
      put(lanes[2], v.z);
    };
    put3(distance, pairs.distance.data());
    for (std::size_t c = 0; c < 3; ++c) put3(l[c], pairs.l.data() + 3 * c);
    put3(k.p, pairs.k.data());
    put3(k.e, pairs.k.data() + 3);
  }
};

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
