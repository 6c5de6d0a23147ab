/// \file
/// The mathematics of scene_filter.h (a Gaussian as an ellipsoid) and k_function.h (K and its slope), lane by
/// lane. The scalar code there is the reference; tests compare the two.
// clang-format off
#if defined(PALPATE_COLLISION_PAIR_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_PAIR_LANES_INL_H_
#undef PALPATE_COLLISION_PAIR_LANES_INL_H_
#else
#define PALPATE_COLLISION_PAIR_LANES_INL_H_
#endif
// clang-format on

#include <palpate/collision/index_layout.h>
#include <palpate/collision/lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DFloat = hn::CappedTag<float, kIndexWidth>;
using DDouble = hn::CappedTag<double, 8>;
using Floats = Lanes<DFloat>;
using Doubles = Lanes<DDouble>;
using TwoFloats = Lanes<DFloat, 2>;
using TwoDoubles = Lanes<DDouble, 2>;

/// Gaussians as solids, one per lane: semi-axis vectors k sigma_i r_i in the captured frame.
template <class L>
struct Solid {
  Vec3<L> center;  ///< relative to the origin
  Vec3<L> axis[3];
  L opacity;  ///< alpha
};

/// The columns of the rotation matrix of the quaternion (w, x, y, z), of any length but zero, times the
/// lengths.
template <class L>
HWY_INLINE void scaled_rotation(const L& qw, const L& qx, const L& qy, const L& qz, const Vec3<L>& length,
                                Vec3<L> (&column)[3]) {
  const L s = 2.0 / fma(qw, qw, fma(qx, qx, fma(qy, qy, qz * qz)));
  const L x = s * qx, y = s * qy, z = s * qz;
  const L xx = x * qx, yy = y * qy, zz = z * qz;
  const L xy = x * qy, xz = x * qz, yz = y * qz;
  const L wx = x * qw, wy = y * qw, wz = z * qw;
  column[0] = length.x * Vec3<L>{1.0 - (yy + zz), xy + wz, xz - wy};
  column[1] = length.y * Vec3<L>{xy - wz, 1.0 - (xx + zz), yz + wx};
  column[2] = length.z * Vec3<L>{xz + wy, yz - wx, 1.0 - (xx + yy)};
}

/// KFunction: the coefficients of K.
template <class L>
struct KLanes {
  Vec3<L> p;  ///< p0 p1 p2
  Vec3<L> e;  ///< e1 e2 e3
};

/// Computes the coefficients from d' and the columns of L.
template <class L>
HWY_INLINE KLanes<L> k_function(const Vec3<L>& d, const Vec3<L> (&l)[3]) {
  const Vec3<L> c01 = cross(l[0], l[1]), c12 = cross(l[1], l[2]), c20 = cross(l[2], l[0]);
  const auto square = [](const L& x) HWY_ATTR { return x * x; };
  return {{squared_norm(d),
           squared_norm(cross(l[0], d)) + (squared_norm(cross(l[1], d)) + squared_norm(cross(l[2], d))),
           square(dot(c01, d)) + (square(dot(c12, d)) + square(dot(c20, d)))},
          {squared_norm(l[0]) + (squared_norm(l[1]) + squared_norm(l[2])),
           squared_norm(c01) + (squared_norm(c12) + squared_norm(c20)), square(dot(c01, l[2]))}};
}

/// Numerator and denominator of f = 1 - K at t, f = t P / ((1 + t) E), and the terms they are made of.
template <class L>
struct FTerms {
  L a1, a2;      ///< p1 t, p2 t^2
  L b1, b2, b3;  ///< e1 t, e2 t^2, e3 t^3
  L P, E, q;     ///< q = 1 + t

  HWY_INLINE FTerms(const KLanes<L>& k, const L& t) {
    const L t2 = t * t;
    a1 = k.p.y * t;
    a2 = k.p.z * t2;
    b1 = k.e.x * t;
    b2 = k.e.y * t2;
    b3 = k.e.z * (t2 * t);
    P = k.p.x + (a1 + a2);
    E = 1.0F + (b1 + (b2 + b3));
    q = 1.0F + t;
  }
};

/// f, g = d ln f / d ln t and h = dg / d ln t (slope_at() of k_function.cpp; here in the short form, whose
/// cancellation on a plateau of K the certificate of minimize() takes account of).
template <class L>
struct FSlope {
  L f, g, h;
  L rE, rq;  ///< one over E and 1 + t

  HWY_INLINE FSlope(const FTerms<L>& x, const L& t) {
    const L Eq = x.E * x.q;
    const L inverse = reciprocal(x.P * Eq);  // one for three
    const L rP = inverse * Eq, rEq = inverse * x.P;
    rE = rEq * x.q;
    rq = rEq * x.E;
    f = (t * x.P) * rEq;
    const L twice_a2 = x.a2 + x.a2, twice_b2 = x.b2 + x.b2;
    const L p_mean = rP * (x.a1 + twice_a2);
    const L p_square = rP * fma(L(2.0F), twice_a2, x.a1);
    const L e_mean = rE * fma(L(3.0F), x.b3, x.b1 + twice_b2);
    const L e_square = rE * fma(L(9.0F), x.b3, fma(L(2.0F), twice_b2, x.b1));
    g = (rq + p_mean) - e_mean;
    h = (fnma(p_mean, p_mean, p_square) - (t * rq) * rq) - fnma(e_mean, e_mean, e_square);
  }
};

/// A Newton step in ln t towards the maximum of f, clamped to length 1; where f is not concave, a step of
/// length 1 uphill.
template <class L>
HWY_INLINE L newton_step(const FSlope<L>& s) {
  const L newton = -s.g * quick_reciprocal(s.h);
  const L step = select(s.h < 0.0F, newton, copy_sign(L(1.0F), s.g));
  return max(L(-1.0F), min(L(1.0F), step));
}

/// t e^s for |s| <= 1, to second order, which suffices for a step.
template <class L>
HWY_INLINE L advance(const L& t, const L& s) {
  return t * fma(s, fma(s, L(0.5F), L(1.0F)), L(1.0F));
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target
