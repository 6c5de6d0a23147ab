/// \file
/// Stage 4 of contact_kernel.h: the minimum of K, certified, and the contact there; in double or in single
/// precision.
// clang-format off
#if defined(PALPATE_COLLISION_CONTACT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_CONTACT_LANES_INL_H_
#undef PALPATE_COLLISION_CONTACT_LANES_INL_H_
#else
#define PALPATE_COLLISION_CONTACT_LANES_INL_H_
#endif
// clang-format on

#include <palpate/collision/group_lanes-inl.h>
#include <palpate/collision/search_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Maximum number of Newton steps in ln t. After the search one or two suffice; a plateau takes more. Pairs
/// not certified by then, one in a million, go to the scalar code, which always converges.
constexpr int kMostSteps = 10;

/// Convergence criteria of a lane.
template <typename T>
struct Done;
template <>
struct Done<double> {
  /// Length of the last step. Its square, 1e-10, is the error that remains in ln t, and with it in direction;
  /// the error in K is the square of that.
  static constexpr double kLastStep = 1e-5;
  /// Largest bound on K - K_min (see minimize). A contact closer to touching than its bound goes to the
  /// scalar code too, so that verdicts do not depend on this.
  static constexpr double kCertificate = 1e-5;
  /// Absolute rounding of g, a sum of numbers up to 3.
  static constexpr double kSlopeRounding = 2e-15;
  /// If h is not below minus this, its rounding makes a Newton step no better than kLastStep.
  static constexpr double kLeastBend = 1e-9;
  /// Stands for infinity: 1 - lambda is then below the resolution of lambda.
  static constexpr double kInfiniteT = 1e16;
  /// Distance of the centres in tool radii below which only the scalar code determines the normal.
  static constexpr double kLeastDistance = 1e-10;
};
template <>
struct Done<float> {
  static constexpr float kLastStep = 1e-3F;
  static constexpr float kCertificate = 1e-3F;
  static constexpr float kSlopeRounding = 1e-6F;
  static constexpr float kLeastBend = 1e-3F;
  static constexpr float kInfiniteT = 1e8F;
  static constexpr float kLeastDistance = 1e-5F;
};

/// Of a flat Gaussian (e3 = 0), K has its minimum at lambda = 1 if it falls towards there: if
/// a = lim g t = 1 + e1 / e2 - p1 / p2 is positive, beyond doubt.
template <class L>
HWY_INLINE auto least_at_infinity(const KLanes<L>& k) {
  using T = typename L::T;
  const L e = k.e.x / k.e.y, p = k.p.y / k.p.z;
  return (k.e.z == T{0}) & ((T{1} + e) - p > T{1e5} * Done<T>::kSlopeRounding * ((T{1} + e) + p));
}

/// Bound on the relative error of f where that is near 1 or above: DoubleRounding or SingleRounding.
template <class L>
class RoundingBound;

template <>
class RoundingBound<TwoDoubles> {
 public:
  using L = TwoDoubles;

  HWY_INLINE RoundingBound(const KLanes<L>& k, const ToolFrame& tool) {
    const DoubleRounding& r = tool.rounding;
    x_per_t_ = k.e.x * r.per_extent;
    at_minimum_ = fma(k.p.x, L(r.per_distance), x_per_t_ + r.constant);
  }
  HWY_INLINE L at(const FTerms<L>&, const FSlope<L>& slope, const L& t) const {
    const L x = x_per_t_ * t, beyond = max(-slope.g, L(0.0)) + Done<double>::kSlopeRounding;
    return sqrt(fma(x, fma(L(128.0), x, beyond), at_minimum_));
  }
  /// At lambda = 1, where K falls towards that.
  HWY_INLINE L at_infinity() const { return sqrt(at_minimum_); }

 private:
  L x_per_t_, at_minimum_;
};

template <>
class RoundingBound<TwoFloats> {
 public:
  using L = TwoFloats;

  HWY_INLINE RoundingBound(const KLanes<L>& k, const ToolFrame& tool) : k_(k), tool_(tool) {}

  HWY_INLINE L at(const FTerms<L>& x, const FSlope<L>& slope, const L&) const {
    return denominator_bound(x, tool_.single) * slope.rE - 1.0F;
  }
  HWY_INLINE L at_infinity() const {
    const FTerms<L> end(k_, L(Done<float>::kInfiniteT));
    return denominator_bound(end, tool_.single) * reciprocal(end.E) - 1.0F;
  }

 private:
  const KLanes<L>& k_;
  const ToolFrame& tool_;
};

/// In double: makes t, the argmin, and K there functions of the pair alone. Newton's method leaves an error
/// of kLastStep^2 in t that depends on the start, which differs between a fresh query and a tracked tool; a
/// force on the edge between two surfaces would amplify that to newtons. Rounding t removes the dependence,
/// and one step from there, 2^-18 in ln t, is as accurate as before.
template <class L>
HWY_INLINE void settle(const KLanes<L>& k, L& t, L& k_min) {
  if constexpr (sizeof(typename L::T) == sizeof(double)) {
    constexpr int kDigits = 17;
    constexpr double kLongest = 0x1p-17;  // on a plateau Newton's step may be anything
    t = rounded<kDigits>(t);
    const FSlope<L> at(FTerms<L>(k, t), t);
    const L s = max(L(-kLongest), min(L(kLongest), newton_step(at)));
    k_min = 1.0 - fma(at.f, 0.5 * (at.g * s), at.f);
    t = advance(t, s);
  }
}

/// Minimises K for the open lanes from i on, starting at t, which becomes the argmin.
///
/// K is convex in lambda, so that from any lambda it can decrease by at most |K'| times the distance to the
/// end of [0, 1]; with K' = -f g / (lambda (1 - lambda)) that is
///
///     K - K_min <= f g / lambda (g > 0)    or    f |g| / (1 - lambda) (g < 0),
///
/// independent of Newton's convergence: the certificate. Where |g| is within its rounding error, both ends
/// count.
template <class L>
HWY_INLINE void minimize(PairsOf<L>& pairs, std::size_t i, const ToolFrame& tool) {
  using T = typename L::T;
  using Mask = typename L::Mask;
  using Limit = Done<T>;
  const KLanes<L> k = load_k<L>(pairs, i);
  const L guess = load<L>(pairs.t, i), latest(Limit::kInfiniteT);
  L t = select((guess >= T{1e-30F}) & (guess <= latest), guess, L(T{1}));  // NaN becomes 1, too
  const RoundingBound<L> bound(k, tool);
  const auto far = k.p.x > Limit::kLeastDistance * Limit::kLeastDistance;

  L k_min(T{1}), t_min = t;
  std::uint32_t undecided = get_bits<L>(pairs.open, i), open = undecided, sure = 0;
  const auto decide = [&](const Mask& which, const L& k_there, const L& t_there, const Mask& apart,
                          const Mask& touch) HWY_ATTR {
    const std::uint32_t decided = undecided & bits_of(which);
    const Mask write = mask_of<decltype(L::d()), L::kVectors>(decided);
    k_min = select(write, k_there, k_min);
    t_min = select(write, t_there, t_min);
    open &= ~(decided & bits_of(apart));
    sure |= decided & bits_of(touch & far);
    undecided &= ~decided;
  };
  if (bits_of(k.e.z == T{0}) != 0) {
    const L k_end = T{1} - k.p.z / k.e.y, rounding = bound.at_infinity();
    decide(least_at_infinity(k), k_end, latest, k_end<-rounding, k_end> rounding);
  }
  for (int step = 0; step < kMostSteps && undecided != 0; ++step) {
    const FTerms<L> x(k, t);
    const FSlope<L> at(x, t);
    const L s = newton_step(at);
    const L k_here =
        T{1} - fma(at.f, T{0.5} * (at.g * s), at.f);  // at the end of the step ln f is higher by g s / 2

    const L size_g = abs(at.g), lambda = t * at.rq, rounding = bound.at(x, at, t);
    const L way =
        select(size_g <= Limit::kSlopeRounding, min(lambda, at.rq), select(at.g > T{0}, lambda, at.rq));
    const L fall = at.f * (size_g + Limit::kSlopeRounding);  // the certificate, times `way`
    const Mask found =
        (fall <= way * Limit::kCertificate) & (at.h < -Limit::kLeastBend) & (abs(s) <= Limit::kLastStep);
    const Mask apart = (at.f > T{1} + rounding) & (at.f < std::numeric_limits<float>::max());
    t = min(advance(t, s), latest);
    decide(found | apart, k_here, t, apart, (k_here - rounding) * way > fall);
  }
  if (open != 0) settle(k, t_min, k_min);
  store(t_min, pairs.t, i);
  store(k_min, pairs.k_min, i);
  set_bits<L>(pairs.open, i, open);
  set_bits<L>(pairs.sure, i, open & sure);
}

/// (I + t L L^T)^-1 d' det(I + t L L^T), by the adjugate, as solve_whitened().
template <class L>
HWY_INLINE Vec3<L> adjugate_times_distance(const Vec3<L>& d, const Vec3<L> (&l)[3], const L& t) {
  const Vec3<L> c01 = cross(l[0], l[1]), c12 = cross(l[1], l[2]), c20 = cross(l[2], l[0]);
  const Vec3<L> first =
      cross(l[0], cross(d, l[0])) + cross(l[1], cross(d, l[1])) + cross(l[2], cross(d, l[2]));
  const Vec3<L> second = fma(dot(c01, d), c01, fma(dot(c12, d), c12, dot(c20, d) * c20));
  return fma(t, fma(t, second, first), d);
}

/// One number per lane of L, read from memory as doubles.
template <class L>
struct InMemory {
  alignas(64) typename L::T number[hn::MaxLanes(L::d())];

  HWY_INLINE InMemory(const L& x) { hn::Store(x.v[0], L::d(), number); }

  HWY_INLINE Doubles at(std::size_t i) const {
    if constexpr (sizeof(typename L::T) == sizeof(double)) {
      return Doubles(hn::Load(DDouble(), number + i));
    } else {
      return Doubles(hn::PromoteTo(DDouble(), hn::Load(hn::Rebind<float, DDouble>(), number + i)));
    }
  }
};

/// Points of one pair per lane of L, relative to the tool's centre in the world frame; in memory, to be read
/// as doubles.
template <class L>
struct PointsInMemory {
  InMemory<L> x, y, z;

  HWY_INLINE PointsInMemory(const Vec3<L>& v) : x(v.x), y(v.y), z(v.z) {}
};

/// Computes the contacts at the minimum, for the lanes from i on.
template <class L>
HWY_INLINE void contacts_at(PairsOf<L>& pairs, std::size_t i, const ToolFrame& tool) {
  using T = typename L::T;
  const Vec3<L> distance = load3<L>(pairs.distance, i);
  const Vec3<L> l[3] = {load3<L>(pairs.l, i, 0), load3<L>(pairs.l, i, 3), load3<L>(pairs.l, i, 6)};
  const L t = load<L>(pairs.t, i);
  const FTerms<L> x(load_k<L>(pairs, i), t);
  const L inverse_Eq = T{1} / (x.E * x.q);
  const Vec3<L> y = (inverse_Eq * x.q) * adjugate_times_distance(distance, l, t);
  // World frame: dK/dc_tool is along -W^T y, the way out along q = W^T y; the columns of W^-1 are the tool's
  // axes.
  const Eigen::Matrix<T, 3, 3> W_transposed = tool.world.W.transpose().template cast<T>();
  const Vec3<L> q = broadcast<L>(W_transposed) * y;
  const L inverse_q = reciprocal_sqrt(squared_norm(q));
  const Eigen::Matrix<T, 3, 3> minus_axes = -tool.world.ellipsoid.axes.template cast<T>();
  const Matrix3<L> axes = broadcast<L>(minus_axes);
  // Depth, h_tool + h_gaussian - n . d, in whitened coordinates: |y|, |L^T y| and y . d', over |q|.
  const auto norm = [&](const Vec3<L>& v) HWY_ATTR {
    const L squared = max(squared_norm(v), L(T{1e-36F}));
    return squared * reciprocal_sqrt(squared);
  };
  const L extents = norm(y) + norm(Vec3<L>{dot(l[0], y), dot(l[1], y), dot(l[2], y)});

  const PointsInMemory<L> normal(inverse_q * q), point(axes * y), center(axes * distance);
  const InMemory<L> depth(inverse_q * (extents - dot(y, distance))),
      lambda(min(t * (inverse_Eq * x.E), L(T{1}))), k_min(load<L>(pairs.k_min, i));
  const Vec3<Doubles> origin = broadcast<Doubles>(tool.world.ellipsoid.center);
  for (std::size_t j = 0; j < L::width(); j += Doubles::width()) {
    const auto put = [&](std::size_t row, const Doubles& a, const Doubles& b) HWY_ATTR {
      hn::StoreInterleaved2(a.v[0], b.v[0], DDouble(), pairs.row[row][i + j].data());
    };
    put(0, k_min.at(j), lambda.at(j));
    put(1, origin.x + center.x.at(j), origin.y + center.y.at(j));
    put(2, origin.z + center.z.at(j), origin.x + point.x.at(j));
    put(3, origin.y + point.y.at(j), origin.z + point.z.at(j));
    put(4, normal.x.at(j), normal.y.at(j));
    put(5, normal.z.at(j), depth.at(j));
  }
}

/// Computes minimum and contact of the first `n` pairs.
template <typename T, class Two, class One>
HWY_INLINE void solve(WhitenedPairs<T>& pairs, std::size_t n, const ToolFrame& tool) {
  for (std::size_t i = 0; i < n; i += 2 * Two::width()) minimize<Two>(pairs, i, tool);
  for (std::size_t i = 0; i < n; i += One::width()) {
    if (get_bits<One>(pairs.open, i) != 0) contacts_at<One>(pairs, i, tool);
  }
}

/// Rounds the coefficients of `n` pairs to single precision, for the search.
HWY_INLINE void round_coefficients(const WhitenedPairs<double>& pairs, std::size_t n,
                                   WhitenedPairs<float>& rounded) {
  const hn::Rebind<float, DDouble> half;
  for (std::size_t c = 0; c < pairs.k.size(); ++c) {
    for (std::size_t i = 0; i < n; i += Doubles::width())
      hn::Store(hn::DemoteTo(half, hn::Load(DDouble(), &pairs.k[c][i])), half, &rounded.k[c][i]);
  }
}

/// Adopts the results of the search.
HWY_INLINE void adopt(const WhitenedPairs<float>& searched, std::size_t n, WhitenedPairs<double>& pairs) {
  for (std::size_t i = 0; i < n; i += Doubles::width()) {
    const auto t = hn::Load(hn::Rebind<float, DDouble>(), &searched.t[i]);
    hn::Store(hn::PromoteTo(DDouble(), t), DDouble(), &pairs.t[i]);
  }
  pairs.open = searched.open;
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
