/// \file
/// References for the overlap test that share nothing with src/palpate/collision: no whitening, no
/// polynomial, no Newton's method. Slow, and as independent of the code under test as it gets.
///
/// With the tool's covariance B, the Gaussian's A, d = c_tool - c_gaussian and t = l / (1-l),
///
///     1 - K = l (1-l) d^T [ (1-l) B + l A ]^-1 d = t/(1+t) d^T [ B + t A ]^-1 d,
///
/// evaluated with a Cholesky solve in the frame of the Gaussian's own axes, longest first. There A
/// is graded, so that the solve stays accurate for semi-axes of any ratio, zero included (a disc, a
/// needle and a point are plain cases), and the minimum is found by bisection on the sign of
///
///     d(1-K)/dl ~ z^T B z - t^2 z^T A z,   z = [ B + t A ]^-1 d.
#pragma once

#include <array>
#include <cfloat>
#include <cmath>
#include <cstddef>

#include <palpate/geometry/ellipsoid.h>

namespace palpate::test {

#if LDBL_MANT_DIG >= 113
using Quad = long double;
#else
__extension__ typedef __float128 Quad;  ///< 113-bit significand
#endif

template <typename Real>
struct Vec3 {
  Real v[3];

  Real& operator[](std::size_t i) { return v[i]; }
  const Real& operator[](std::size_t i) const { return v[i]; }
};

inline long double square_root(long double v) { return std::sqrt(v); }
#if LDBL_MANT_DIG < 113
/// Newton's method on the 64 bits of long double: two steps give more than 113.
inline Quad square_root(Quad v) {
  if (v == 0) return 0;
  Quad r = std::sqrt(static_cast<long double>(v));
  r = (r + v / r) / 2;
  return (r + v / r) / 2;
}
#endif

template <typename Real>
Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename Real>
Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <typename Real>
Vec3<Real> operator+(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <typename Real>
Vec3<Real> operator-(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <typename Real>
Vec3<Real> operator*(Real s, const Vec3<Real>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
template <typename Real>
Real norm(const Vec3<Real>& a) {
  return square_root(dot(a, a));
}

/// An ellipsoid in more than double precision.
template <typename Real>
struct Solid {
  Vec3<Real> center{};
  std::array<Vec3<Real>, 3> axes{};  ///< semi-axis vectors, orthogonal up to rounding

  Solid() = default;
  explicit Solid(const Ellipsoid& e) {
    for (int i = 0; i < 3; ++i) {
      const auto n = static_cast<std::size_t>(i);
      center[n] = e.center[i];
      axes[n] = {e.axes(0, i), e.axes(1, i), e.axes(2, i)};
    }
  }
};

/// Minimum of K and what follows from where it is.
template <typename Real>
struct OracleMinimum {
  Real k_min{};
  /// lambda / (1 - lambda), in [2^-300, 2^300]; the ends stand for 0 and infinity.
  Real t{};
  Vec3<Real> point{};  ///< m(lambda) of paper eq. 5
  Vec3<Real> z{};      ///< [B + t A]^-1 d; the gradient of K_min in c_tool is -2 t/(1+t) z

  Real lambda() const { return t / (1 + t); }
  Real one_minus_lambda() const { return 1 / (1 + t); }
};

/// One pair. `Real` is Quad, or long double where speed matters.
template <typename Real>
class PairOracle {
 public:
  PairOracle(const Solid<Real>& tool, const Solid<Real>& gaussian);
  PairOracle(const Ellipsoid& tool, const Ellipsoid& gaussian)
      : PairOracle(Solid<Real>(tool), Solid<Real>(gaussian)) {}

  Real k_at_t(Real t) const;
  Real k_at_lambda(Real lambda) const;
  /// Sign of d(1-K)/dlambda, up to a positive factor.
  Real slope(Real t) const;

  /// By bisection over all of t, down to neighbouring numbers.
  OracleMinimum<Real> minimize() const;
  /// The same from a guess, which is only trusted if the slope changes sign around it.
  OracleMinimum<Real> minimize_near(Real t) const;
  /// K_min alone, good to 1e-18; or any K below `stop_below`, as soon as there is one. Cheap.
  Real k_min(Real stop_below) const;

 private:
  OracleMinimum<Real> at(Real t) const;
  Vec3<Real> solve(Real t) const;
  OracleMinimum<Real> bisect(Real low, Real high) const;

  std::array<Vec3<Real>, 3> frame_;  ///< orthonormal, along the Gaussian's axes, longest first
  Vec3<Real> center_;                ///< of the tool, world frame
  Vec3<Real> d_;                     ///< in frame_, as all that follows
  std::array<Vec3<Real>, 3> a_, b_;  ///< covariances A and B
};

extern template class PairOracle<long double>;
extern template class PairOracle<Quad>;

/// The minimum in quadruple precision: localised in long double, certified in Quad, and by
/// bisection in Quad alone where that fails.
OracleMinimum<Quad> oracle_minimum(const Ellipsoid& tool, const Ellipsoid& gaussian);

/// Paper eqs. 5-6 word for word in Quad, inverse covariances and all. Both solids must have a
/// volume, and be so near the origin and so round that Quad survives the inversion.
struct LiteralPaper {
  LiteralPaper(const Ellipsoid& tool, const Ellipsoid& gaussian);

  Vec3<Quad> m(Quad lambda) const;
  Quad k(Quad lambda) const;

  Vec3<Quad> c_tool, c_gaussian;
  std::array<Vec3<Quad>, 3> B_tool, A_gaussian;  ///< shape matrices: inverse covariances
};

}  // namespace palpate::test
