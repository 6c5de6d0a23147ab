/// \file
/// SIMD lanes: arithmetic on one pair per lane, written like scalar code. A thin layer: every operation is
/// one processor instruction by way of Highway, or a few where noted. Included once for every instruction
/// set, by Highway's foreach_target.h; hence no plain include guard.
// clang-format off
#if defined(PALPATE_COLLISION_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_LANES_INL_H_
#undef PALPATE_COLLISION_LANES_INL_H_
#else
#define PALPATE_COLLISION_LANES_INL_H_
#endif
// clang-format on

#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Core>

#include <hwy/highway.h>

#include <palpate/collision/pack_table.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A boolean for each lane of Lanes<D, N>.
template <class D, std::size_t N>
struct LaneMask {
  HWY_INLINE LaneMask() {}  // one that is implicit would not be for the target
  hn::Mask<D> m[N];
};

/// N processor vectors, treated as one. With two, the processor works on one while it waits for the other:
/// its out-of-order window is too small to find work on later pairs.
template <class D, std::size_t N = 1>
struct Lanes {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  using Mask = LaneMask<D, N>;
  V v[N];

  Lanes() = default;
  /// The same number in all lanes.
  HWY_INLINE Lanes(T x) {
    for (std::size_t j = 0; j < N; ++j) v[j] = hn::Set(D(), x);
  }
  HWY_INLINE explicit Lanes(V x) requires(N == 1) : v{x} {}

  static constexpr D d() { return D(); }
  static constexpr std::size_t kVectors = N;
  /// Lanes of one vector.
  static HWY_INLINE std::size_t width() { return hn::Lanes(D()); }

  /// Vector j from, or to, the address at(j), which is aligned to a vector.
  template <class At>
  static HWY_INLINE Lanes load(const At& at) {
    Lanes x;
    for (std::size_t j = 0; j < N; ++j) x.v[j] = hn::Load(D(), at(j));
    return x;
  }
  template <class At>
  HWY_INLINE void store(const At& at) const {
    for (std::size_t j = 0; j < N; ++j) hn::Store(v[j], D(), at(j));
  }
};

#define PALPATE_LANES               \
  template <class D, std::size_t N> \
  HWY_INLINE
#define PALPATE_UNARY(name, op)                              \
  PALPATE_LANES Lanes<D, N> name(const Lanes<D, N>& a) {     \
    Lanes<D, N> r;                                           \
    for (std::size_t j = 0; j < N; ++j) r.v[j] = op(a.v[j]); \
    return r;                                                \
  }
// Found as friends would be: a number on either side is taken as the same in all lanes.
#define PALPATE_BINARY(name, op)                                                                            \
  PALPATE_LANES Lanes<D, N> name(const Lanes<D, N>& a, const Lanes<D, N>& b) {                              \
    Lanes<D, N> r;                                                                                          \
    for (std::size_t j = 0; j < N; ++j) r.v[j] = op(a.v[j], b.v[j]);                                        \
    return r;                                                                                               \
  }                                                                                                         \
  PALPATE_LANES Lanes<D, N> name(const Lanes<D, N>& a, hn::TFromD<D> b) { return name(a, Lanes<D, N>(b)); } \
  PALPATE_LANES Lanes<D, N> name(hn::TFromD<D> a, const Lanes<D, N>& b) { return name(Lanes<D, N>(a), b); }
#define PALPATE_COMPARE(name, op)                                                 \
  PALPATE_LANES LaneMask<D, N> name(const Lanes<D, N>& a, const Lanes<D, N>& b) { \
    LaneMask<D, N> r;                                                             \
    for (std::size_t j = 0; j < N; ++j) r.m[j] = op(a.v[j], b.v[j]);              \
    return r;                                                                     \
  }                                                                               \
  PALPATE_LANES LaneMask<D, N> name(const Lanes<D, N>& a, hn::TFromD<D> b) { return name(a, Lanes<D, N>(b)); }
#define PALPATE_LOGIC(name, op)                                                         \
  PALPATE_LANES LaneMask<D, N> name(const LaneMask<D, N>& a, const LaneMask<D, N>& b) { \
    LaneMask<D, N> r;                                                                   \
    for (std::size_t j = 0; j < N; ++j) r.m[j] = op(a.m[j], b.m[j]);                    \
    return r;                                                                           \
  }
#define PALPATE_TERNARY(name, op)                                                                    \
  PALPATE_LANES Lanes<D, N> name(const Lanes<D, N>& a, const Lanes<D, N>& b, const Lanes<D, N>& c) { \
    Lanes<D, N> r;                                                                                   \
    for (std::size_t j = 0; j < N; ++j) r.v[j] = op(a.v[j], b.v[j], c.v[j]);                         \
    return r;                                                                                        \
  }

PALPATE_UNARY(operator-, hn::Neg)
PALPATE_UNARY(abs, hn::Abs)
PALPATE_UNARY(sqrt, hn::Sqrt)
PALPATE_BINARY(operator+, hn::Add)
PALPATE_BINARY(operator-, hn::Sub)
PALPATE_BINARY(operator*, hn::Mul)
PALPATE_BINARY(operator/, hn::Div)
PALPATE_BINARY(min, hn::Min)
PALPATE_BINARY(max, hn::Max)
PALPATE_BINARY(copy_sign, hn::CopySign)
PALPATE_COMPARE(operator<, hn::Lt)
PALPATE_COMPARE(operator<=, hn::Le)
PALPATE_COMPARE(operator>, hn::Gt)
PALPATE_COMPARE(operator>=, hn::Ge)
PALPATE_COMPARE(operator==, hn::Eq)
PALPATE_LOGIC(operator&, hn::And)
PALPATE_LOGIC(operator|, hn::Or)
// a b + c, a b - c and c - a b; one rounding where the processor fuses them.
PALPATE_TERNARY(fma, hn::MulAdd)
PALPATE_TERNARY(fms, hn::MulSub)
PALPATE_TERNARY(fnma, hn::NegMulAdd)
/// The processor's own approximations: 8 to 14 bits.
PALPATE_UNARY(rough_reciprocal, hn::ApproximateReciprocal)

#undef PALPATE_UNARY
#undef PALPATE_BINARY
#undef PALPATE_COMPARE
#undef PALPATE_LOGIC
#undef PALPATE_TERNARY

/// `yes` where the mask is set, else `no`.
PALPATE_LANES Lanes<D, N> select(const LaneMask<D, N>& mask, const Lanes<D, N>& yes, const Lanes<D, N>& no) {
  Lanes<D, N> r;
  for (std::size_t j = 0; j < N; ++j) r.v[j] = hn::IfThenElse(mask.m[j], yes.v[j], no.v[j]);
  return r;
}

/// `b` and not `a`.
PALPATE_LANES LaneMask<D, N> and_not(const LaneMask<D, N>& a, const LaneMask<D, N>& b) {
  LaneMask<D, N> r;
  for (std::size_t j = 0; j < N; ++j) r.m[j] = hn::AndNot(a.m[j], b.m[j]);
  return r;
}

/// Number of set lanes of the mask.
PALPATE_LANES std::size_t count_of(const LaneMask<D, N>& mask) {
  std::size_t count = 0;
  for (std::size_t j = 0; j < N; ++j) count += hn::CountTrue(D(), mask.m[j]);
  return count;
}

/// A mask of the first `n` lanes.
template <class L>
HWY_INLINE LaneMask<decltype(L::d()), 1> first_lanes(std::size_t n) {
  LaneMask<decltype(L::d()), 1> mask;
  mask.m[0] = hn::FirstN(L::d(), n);
  return mask;
}

/// A mask of the lanes that are not NaN.
PALPATE_LANES LaneMask<D, N> is_number(const Lanes<D, N>& a) {
  LaneMask<D, N> r;
  for (std::size_t j = 0; j < N; ++j) r.m[j] = hn::Eq(a.v[j], a.v[j]);
  return r;
}

/// A mask of the lanes whose sign bit is set, including NaN.
PALPATE_LANES LaneMask<D, N> is_negative(const Lanes<D, N>& a) {
  const hn::RebindToSigned<D> signed_lanes;
  LaneMask<D, N> r;
  for (std::size_t j = 0; j < N; ++j) {
    r.m[j] = hn::RebindMask(D(), hn::Lt(hn::BitCast(signed_lanes, a.v[j]), hn::Zero(signed_lanes)));
  }
  return r;
}

/// Rounds to the nearest number with `kDigits` binary digits after the first.
template <int kDigits, class D, std::size_t N>
HWY_INLINE Lanes<D, N> rounded(const Lanes<D, N>& a) {
  const hn::RebindToUnsigned<D> bits;
  using Bits = hn::TFromD<decltype(bits)>;
  constexpr Bits kUnit = Bits{1} << (hwy::MantissaBits<hn::TFromD<D>>() - kDigits);
  Lanes<D, N> r;
  for (std::size_t j = 0; j < N; ++j) {
    const auto carried = hn::Add(hn::BitCast(bits, a.v[j]), hn::Set(bits, kUnit / 2));
    r.v[j] = hn::BitCast(D(), hn::And(carried, hn::Set(bits, ~(kUnit - 1))));
  }
  return r;
}

/// The lanes of all vectors as bits, the first lane in bit 0; up to 32 lanes.
PALPATE_LANES std::uint32_t bits_of(const LaneMask<D, N>& mask) {
  std::uint32_t bits = 0;
  for (std::size_t j = 0; j < N; ++j) {
    std::uint8_t raw[8] = {};
    hn::StoreMaskBits(D(), mask.m[j], raw);
    bits |= (raw[0] | static_cast<std::uint32_t>(raw[1]) << 8) << (j * hn::Lanes(D()));
  }
  return bits;
}

/// The inverse of bits_of().
template <class D, std::size_t N>
HWY_INLINE LaneMask<D, N> mask_of(std::uint32_t bits) {
  LaneMask<D, N> mask;
  for (std::size_t j = 0; j < N; ++j) {
    const std::uint32_t part = bits >> (j * hn::Lanes(D()));
    const std::uint8_t raw[8] = {static_cast<std::uint8_t>(part & 0xffU),
                                 static_cast<std::uint8_t>(part >> 8 & 0xffU)};
    mask.m[j] = hn::LoadMaskBits(D(), raw);
  }
  return mask;
}

/// 1 / a: in single precision to nearly all digits, by the approximation and one Newton step; in double by
/// division.
PALPATE_LANES Lanes<D, N> reciprocal(const Lanes<D, N>& a) {
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    return 1.0 / a;
  } else {
    const Lanes<D, N> r = rough_reciprocal(a);
    return r * fnma(a, r, Lanes<D, N>(2.0F));
  }
}

/// 1 / a to a dozen bits or more, for |a| from 1e-37 to 1e37. A division would occupy the processor's only
/// divider for ten to sixteen cycles.
PALPATE_LANES Lanes<D, N> quick_reciprocal(const Lanes<D, N>& a) {
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    using F = Lanes<hn::Rebind<float, D>>;
    Lanes<D, N> r;
    for (std::size_t j = 0; j < N; ++j) {
      const F single(hn::DemoteTo(hn::Rebind<float, D>(), a.v[j]));
      r.v[j] = hn::PromoteTo(D(), reciprocal(single).v[0]);
    }
    return r;
  } else {
    return rough_reciprocal(a);
  }
}

/// 1 / sqrt(a) to a few units in the last place, for a from 1e-37 to 1e37: the approximation for floats and
/// Newton steps, since the divider would take twenty cycles.
PALPATE_LANES Lanes<D, N> reciprocal_sqrt(const Lanes<D, N>& a) {
  using T = hn::TFromD<D>;
  // Each step doubles the digits, of which NEON has eight to start with, and x86 eleven.
  constexpr int kSteps = (sizeof(T) == sizeof(double) ? 2 : 1) + (HWY_ARCH_ARM ? 1 : 0);
  Lanes<D, N> r;
  for (std::size_t j = 0; j < N; ++j) {
    if constexpr (sizeof(T) == sizeof(double)) {
      r.v[j] =
          hn::PromoteTo(D(), hn::ApproximateReciprocalSqrt(hn::DemoteTo(hn::Rebind<float, D>(), a.v[j])));
    } else {
      r.v[j] = hn::ApproximateReciprocalSqrt(a.v[j]);
    }
  }
  const Lanes<D, N> half(T{0.5}), half_a = half * a;
  for (int step = 0; step < kSteps; ++step) r = fma(r, fnma(half_a * r, r, half), r);
  return r;
}
#undef PALPATE_LANES

/// Three coordinates, each in lanes.
template <class L>
struct Vec3 {
  L x, y, z;
};

template <class L>
HWY_INLINE Vec3<L> operator+(const Vec3<L>& a, const Vec3<L>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class L>
HWY_INLINE Vec3<L> operator-(const Vec3<L>& a, const Vec3<L>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class L>
HWY_INLINE Vec3<L> operator*(const L& s, const Vec3<L>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
/// s a + b.
template <class L>
HWY_INLINE Vec3<L> fma(const L& s, const Vec3<L>& a, const Vec3<L>& b) {
  return {fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}
template <class L>
HWY_INLINE L dot(const Vec3<L>& a, const Vec3<L>& b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class L>
HWY_INLINE L squared_norm(const Vec3<L>& a) {
  return dot(a, a);
}
template <class L>
HWY_INLINE Vec3<L> cross(const Vec3<L>& a, const Vec3<L>& b) {
  return {fms(a.y, b.z, a.z * b.y), fms(a.z, b.x, a.x * b.z), fms(a.x, b.y, a.y * b.x)};
}

/// One matrix for all lanes.
template <class L>
struct Matrix3 {
  Vec3<L> row[3];
};

template <class L, class T>
HWY_INLINE Vec3<L> broadcast(const Eigen::Matrix<T, 3, 1>& v) {
  return {L(v[0]), L(v[1]), L(v[2])};
}
template <class L, class T>
HWY_INLINE Matrix3<L> broadcast(const Eigen::Matrix<T, 3, 3>& m) {
  Matrix3<L> result;
  for (int i = 0; i < 3; ++i) result.row[i] = {L(m(i, 0)), L(m(i, 1)), L(m(i, 2))};
  return result;
}
template <class L>
HWY_INLINE Vec3<L> operator*(const Matrix3<L>& m, const Vec3<L>& v) {
  return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}

/// Packs the lanes of a mask to the front, in order, for any number of vectors. Uses Highway's Compress where
/// that is an instruction; elsewhere Compress would look up its table again, on the stack, for every vector.
template <class D>
class LanePacker {
 public:
  static constexpr bool kHasInstruction = hn::MaxLanes(D()) > 8;

  HWY_INLINE explicit LanePacker(const LaneMask<D, 1>& mask) : mask_(mask.m[0]), indices_(indices_of(mask)) {}

  /// `to` has room for a whole vector, aligned or not.
  HWY_INLINE void operator()(const Lanes<D>& from, hn::TFromD<D>* to) const {
    if constexpr (kHasInstruction) {
      hn::StoreU(hn::Compress(from.v[0], mask_), D(), to);
    } else {
      hn::StoreU(hn::TableLookupLanes(from.v[0], indices_), D(), to);
    }
  }

 private:
  static HWY_INLINE auto indices_of(const LaneMask<D, 1>& mask) {
    if constexpr (kHasInstruction) {
      return 0;
    } else {
      const auto& row = kPackTable<hn::MaxLanes(D())>[bits_of(mask)];
      return hn::IndicesFromVec(D(), hn::LoadU(hn::RebindToSigned<D>(), row.data()));
    }
  }

  hn::Mask<D> mask_;
  decltype(indices_of(LaneMask<D, 1>())) indices_;
};

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
