/// \file
/// Between WhitenedPairs in memory and lanes.
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

// Members of WhitenedGroup, for load() and store().
constexpr auto kDistance = [](auto& g) -> auto& { return g.distance; };
constexpr auto kL = [](auto& g) -> auto& { return g.l; };
constexpr auto kK = [](auto& g) -> auto& { return g.k; };
constexpr auto kOpacity = [](auto& g) -> auto& { return g.opacity; };
constexpr auto kT = [](auto& g) -> auto& { return g.t; };
constexpr auto kMinimum = [](auto& g) -> auto& { return g.k_min; };
constexpr auto kLambda = [](auto& g) -> auto& { return g.lambda; };
constexpr auto kDepth = [](auto& g) -> auto& { return g.depth; };
constexpr auto kCenter = [](auto& g) -> auto& { return g.center; };
constexpr auto kPoint = [](auto& g) -> auto& { return g.point; };
constexpr auto kNormal = [](auto& g) -> auto& { return g.normal; };

template <class L>
using PairsOf = WhitenedPairs<typename L::T>;

/// A number of as many pairs as L has lanes, from pair i on, which may be of two groups.
template <class L, class Member>
HWY_INLINE L load(const PairsOf<L>& pairs, std::size_t i, const Member& member) {
  return L::load([&](std::size_t j) HWY_ATTR {
    const std::size_t pair = i + j * L::width();
    return &member(pairs.group(pair))[pair % PairsOf<L>::kWidth];
  });
}
template <class L, class Member>
HWY_INLINE void store(const L& x, PairsOf<L>& pairs, std::size_t i, const Member& member) {
  x.store([&](std::size_t j) HWY_ATTR {
    const std::size_t pair = i + j * L::width();
    return &member(pairs.group(pair))[pair % PairsOf<L>::kWidth];
  });
}

/// Three of them, from member(group)[first] on.
template <class L, class Member>
HWY_INLINE Vec3<L> load3(const PairsOf<L>& pairs, std::size_t i, const Member& member,
                         std::size_t first = 0) {
  const auto at = [&](std::size_t c) HWY_ATTR {
    return load<L>(
        pairs, i, [&](const auto& g) -> const auto& { return member(g)[first + c]; });
  };
  return {at(0), at(1), at(2)};
}
template <class L, class Member>
HWY_INLINE void store3(const Vec3<L>& v, PairsOf<L>& pairs, std::size_t i, const Member& member,
                       std::size_t first = 0) {
  const auto at = [&](std::size_t c) {
    return [&member, first, c ](auto& g) -> auto& { return member(g)[first + c]; };
  };
  store(v.x, pairs, i, at(0));
  store(v.y, pairs, i, at(1));
  store(v.z, pairs, i, at(2));
}

template <class L>
HWY_INLINE KLanes<L> load_k(const PairsOf<L>& pairs, std::size_t i) {
  return {load3<L>(pairs, i, kK, 0), load3<L>(pairs, i, kK, 3)};
}

/// The bits of those pairs, the first in bit 0: a group's, or a part of them, or two groups'.
template <class L>
HWY_INLINE std::uint32_t get_bits(const typename PairsOf<L>::Bits& bits, std::size_t i) {
  constexpr std::size_t kWidth = PairsOf<L>::kWidth;
  const std::size_t lanes = L::kVectors * L::width();
  if (lanes <= kWidth) return bits[i / kWidth] >> (i % kWidth) & ((1U << lanes) - 1U);
  return bits[i / kWidth] | bits[i / kWidth + 1] << kWidth;
}
template <class L>
HWY_INLINE void set_bits(typename PairsOf<L>::Bits& bits, std::size_t i, std::uint32_t value) {
  constexpr std::size_t kWidth = PairsOf<L>::kWidth;
  const std::size_t lanes = L::kVectors * L::width();
  if (lanes <= kWidth) {
    const std::uint32_t mask = ((1U << lanes) - 1U) << (i % kWidth);
    bits[i / kWidth] = (bits[i / kWidth] & ~mask) | value << (i % kWidth);
  } else {
    bits[i / kWidth] = value & ((1U << kWidth) - 1U);
    bits[i / kWidth + 1] = value >> kWidth;
  }
}

/// All of the first `n` pairs, and no others.
template <typename T>
HWY_INLINE void open_all(WhitenedPairs<T>& pairs, std::size_t n) {
  for (std::size_t i = 0; i < n; i += pairs.kWidth) {
    const std::size_t left = std::min(pairs.kWidth, n - i);
    pairs.open[i / pairs.kWidth] = static_cast<std::uint32_t>((std::uint64_t{1} << left) - 1);
  }
  if (n % (2 * pairs.kWidth) != 0 && n % (2 * pairs.kWidth) <= pairs.kWidth)
    pairs.open[(n - 1) / pairs.kWidth + 1] = 0;
}

/// A Gaussian as the tool sees it, into lanes i on. `offset` is from its centre to the tool's, captured
/// frame.
template <class L, class Matrix>
HWY_INLINE void whiten(const Vec3<L>& offset, const Vec3<L> (&axis)[3], const L& opacity,
                       const Matrix& tool_W, PairsOf<L>& pairs, std::size_t i) {
  const Matrix3<L> W = broadcast<L>(tool_W);
  const Vec3<L> distance = W * offset;
  const Vec3<L> l[3] = {W * axis[0], W * axis[1], W * axis[2]};
  const KLanes<L> k = k_function(distance, l);
  store3(distance, pairs, i, kDistance);
  for (std::size_t c = 0; c < 3; ++c) store3(l[c], pairs, i, kL, 3 * c);
  store3(k.p, pairs, i, kK, 0);
  store3(k.e, pairs, i, kK, 3);
  store(opacity, pairs, i, kOpacity);
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
