/// \file
/// Stage 3 of contact_kernel.h: single-precision search that rejects pairs that are certainly apart, and
/// approximates the argmin t of K for the others.
// clang-format off
#if defined(PALPATE_COLLISION_SEARCH_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_SEARCH_LANES_INL_H_
#undef PALPATE_COLLISION_SEARCH_LANES_INL_H_
#else
#define PALPATE_COLLISION_SEARCH_LANES_INL_H_
#endif
// clang-format on

#include <limits>

#include <palpate/collision/group_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Largest t that the float lanes use: beyond, K differs from its value at lambda = 1 by no more than a few
/// times the resolution, and up to it P E (1 + t) does not overflow a float for Gaussians up to a thousand
/// times the tool.
constexpr float kLatestT = 1e6F;
/// Number of Newton steps in ln t after the screening step: constant, as a loop with a data-dependent end
/// keeps the processor from starting the next vector. After four from a guess, 99 in 100 pairs of flat
/// Gaussians have converged to the resolution of a float; two suffice from the argmin of the previous tick.
/// Stage 4 handles the others.
constexpr int kStepsFromGuess = 3;
constexpr int kStepsFromLast = 2;

/// Initial guess of t. If the Gaussian were a ball of its extent along d', f would peak at t = 1 / extent,
/// with extent^2 = |L^T d'|^2 / p0 = e1 - p1 / p0. If it is flat, f has a plateau that ends where e3 t^3
/// dominates: there g t = a - (e3 / e2) t^2 + O(1/t) with a = 1 + e1 / e2 - p1 / p2, hence t^2 = a e2 / e3.
/// The guess is the larger of the two.
template <class L>
HWY_INLINE L first_t(const KLanes<L>& k) {
  const L tiny(1e-20F);
  const auto ratio = [](const L& a, const L& b) HWY_ATTR { return a * rough_reciprocal(b); };
  const L extent_squared = max(tiny, k.e.x - ratio(k.p.y, k.p.x));
  const L a_e2 = fnma(ratio(k.p.y, max(k.p.z, tiny)), k.e.y, k.e.x + k.e.y);
  const L t_squared = max(rough_reciprocal(extent_squared), ratio(a_e2, max(k.e.z, tiny)));
  return min(sqrt(t_squared), L(kLatestT));
}

/// Denominator E enlarged by the bound of `rounding`: f = t P / ((1 + t) E) is certainly above 1 where t P
/// exceeds (1 + t) times this.
template <class L>
HWY_INLINE L denominator_bound(const FTerms<L>& x, const SingleRounding& rounding) {
  const L A = 1.0F + x.b1;
  const L relative = fma(L(rounding.per_extent), A, L(1.0F + rounding.constant));
  return fma(x.E, relative, (A * A) * (A * rounding.per_volume));
}

/// One search step: lanes that are certainly apart at t, and an improved t for the others.
template <class L>
struct SearchStep {
  decltype(L() > L()) apart;
  L t;

  HWY_INLINE SearchStep(const KLanes<L>& k, const L& at, const SingleRounding& rounding) {
    const FTerms<L> x(k, at);
    const L tP = at * x.P;
    const auto finite = tP < std::numeric_limits<float>::max();  // an overflow proves nothing
    apart = finite & (tP > x.q * denominator_bound(x, rounding));
    const FSlope<L> slope(x, at);
    t = min(advance(at, newton_step(slope)), L(kLatestT));
  }
};

/// Starting at t, closes those of the first `n` pairs that are apart, and moves t towards the minimum of K
/// for the others. Each step is done for all pairs, so that the processor works on others while some wait for
/// their reciprocals.
HWY_INLINE void search(WhitenedPairs<float>& pairs, std::size_t n, const SingleRounding& rounding,
                       int steps) {
  using L = TwoFloats;
  set_first(pairs.open, n);
  for (int step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i < n; i += L::kVectors * L::width()) {
      const SearchStep<L> next(load_k<L>(pairs, i), load<L>(pairs.t, i), rounding);
      set_bits<L>(pairs.open, i, get_bits<L>(pairs.open, i) & ~bits_of(next.apart));
      store(next.t, pairs.t, i);
    }
  }
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
