#include <support/k_oracle.h>

#include <algorithm>
#include <cstdlib>

namespace palpate::test {
namespace {

constexpr int kMaxExponent = 300;  // of t; size ratios of scenes end at 2^80

template <typename Real>
Real power_of_two(int exponent) {
  Real value = 1;
  for (int i = 0; i < std::abs(exponent); ++i) value *= 2;
  return exponent < 0 ? 1 / value : value;
}

template <typename Real>
Real absolute(Real v) {
  return v < 0 ? -v : v;
}

/// A unit vector across `a` (and across `b`, if that is not zero).
template <typename Real>
Vec3<Real> unit_across(const Vec3<Real>& a, const Vec3<Real>& b) {
  Vec3<Real> c = cross(a, b);
  if (dot(b, b) == 0) {
    std::size_t least = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (absolute(a[i]) < absolute(a[least])) least = i;
    Vec3<Real> e{};
    e[least] = 1;
    c = cross(a, e);
  }
  return (1 / norm(c)) * c;
}

template <typename Real>
std::array<Vec3<Real>, 3> covariance(const std::array<Vec3<Real>, 3>& frame,
                                     const std::array<Vec3<Real>, 3>& axes) {
  std::array<Vec3<Real>, 3> components;  // [axis][frame direction]
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 3; ++i) components[k][i] = dot(frame[i], axes[k]);
  std::array<Vec3<Real>, 3> s{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) s[i][j] += components[k][i] * components[k][j];
  return s;
}

template <typename Real>
Real quadratic(const std::array<Vec3<Real>, 3>& s, const Vec3<Real>& v) {
  Real sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) sum += v[i] * s[i][j] * v[j];
  return sum;
}

using Matrix = std::array<Vec3<Quad>, 3>;

Matrix inverse(const Matrix& m) {
  const Vec3<Quad> r0 = cross(m[1], m[2]), r1 = cross(m[2], m[0]), r2 = cross(m[0], m[1]);
  const Quad det = dot(m[0], r0);
  Matrix out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = {r0[i] / det, r1[i] / det, r2[i] / det};
  return out;
}

Vec3<Quad> times(const Matrix& m, const Vec3<Quad>& v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

Matrix shape_matrix(const Ellipsoid& e) {
  const Matrix world{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  return inverse(covariance(world, Solid<Quad>(e).axes));
}

}  // namespace

template <typename Real>
PairOracle<Real>::PairOracle(const Solid<Real>& tool, const Solid<Real>& gaussian) : center_(tool.center) {
  std::array<Vec3<Real>, 3> axes = gaussian.axes;
  std::sort(axes.begin(), axes.end(),
            [](const Vec3<Real>& a, const Vec3<Real>& b) { return dot(a, a) > dot(b, b); });
  if (dot(axes[0], axes[0]) == 0) {
    frame_ = {Vec3<Real>{1, 0, 0}, Vec3<Real>{0, 1, 0}, Vec3<Real>{0, 0, 1}};
  } else {
    frame_[0] = (1 / norm(axes[0])) * axes[0];
    frame_[2] = unit_across(frame_[0], axes[1]);
    frame_[1] = cross(frame_[2], frame_[0]);
  }
  // What Gram-Schmidt makes zero is set to zero, so that rounding gives a flat solid no thickness.
  std::array<Vec3<Real>, 3> parts;  // [axis][frame direction]
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 3; ++i) parts[k][i] = i > k ? Real(0) : dot(frame_[i], axes[k]);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      a_[i][j] = 0;
      for (std::size_t k = 0; k < 3; ++k) a_[i][j] += parts[k][i] * parts[k][j];
    }
  }
  b_ = covariance(frame_, tool.axes);
  const Vec3<Real> d = tool.center - gaussian.center;
  d_ = {dot(frame_[0], d), dot(frame_[1], d), dot(frame_[2], d)};
}

template <typename Real>
Vec3<Real> PairOracle<Real>::solve(Real t) const {
  const auto n = [&](std::size_t i, std::size_t j) { return b_[i][j] + t * a_[i][j]; };
  // L D L^T, the longest axis first.
  const Real d0 = n(0, 0), l10 = n(1, 0) / d0, l20 = n(2, 0) / d0;
  const Real d1 = n(1, 1) - l10 * n(1, 0), l21 = (n(2, 1) - l20 * n(1, 0)) / d1;
  const Real d2 = n(2, 2) - l20 * n(2, 0) - l21 * l21 * d1;
  const Real y0 = d_[0], y1 = d_[1] - l10 * y0, y2 = d_[2] - l20 * y0 - l21 * y1;
  const Real z2 = y2 / d2, z1 = y1 / d1 - l21 * z2;
  return {y0 / d0 - l10 * z1 - l20 * z2, z1, z2};
}

template <typename Real>
Real PairOracle<Real>::k_at_t(Real t) const {
  return 1 - t / (1 + t) * dot(d_, solve(t));
}

template <typename Real>
Real PairOracle<Real>::k_at_lambda(Real lambda) const {
  return lambda <= 0 ? Real(1) : k_at_t(lambda / (1 - lambda));
}

template <typename Real>
Real PairOracle<Real>::slope(Real t) const {
  const Vec3<Real> z = solve(t);
  return quadratic(b_, z) - t * t * quadratic(a_, z);
}

template <typename Real>
OracleMinimum<Real> PairOracle<Real>::at(Real t) const {
  OracleMinimum<Real> m;
  m.t = t;
  const Vec3<Real> z = solve(t);
  m.k_min = 1 - t / (1 + t) * dot(d_, z);
  // m = c_tool - B z, from eq. 5 with A^-1 and B^-1 multiplied out.
  Vec3<Real> bz;
  for (std::size_t i = 0; i < 3; ++i) bz[i] = dot(b_[i], z);
  for (std::size_t i = 0; i < 3; ++i) {
    m.z[i] = m.point[i] = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      m.z[i] += frame_[k][i] * z[k];
      m.point[i] -= frame_[k][i] * bz[k];
    }
    m.point[i] += center_[i];
  }
  return m;
}

template <typename Real>
OracleMinimum<Real> PairOracle<Real>::bisect(Real low, Real high) const {
  constexpr int kSteps = 140;  // the logarithm of t has 9 bits before the point and 113 behind it
  for (int i = 0; i < kSteps; ++i) {
    const Real middle = square_root(low * high);
    if (!(low < middle && middle < high)) break;
    (slope(middle) > 0 ? low : high) = middle;
  }
  return at(high);
}

template <typename Real>
OracleMinimum<Real> PairOracle<Real>::minimize() const {
  if (dot(d_, d_) == 0) return at(1);
  const Real low = power_of_two<Real>(-kMaxExponent), high = power_of_two<Real>(kMaxExponent);
  if (slope(high) > 0) return at(high);
  return bisect(low, high);
}

template <typename Real>
OracleMinimum<Real> PairOracle<Real>::minimize_near(Real t) const {
  if (dot(d_, d_) == 0) return at(1);
  const Real end = power_of_two<Real>(kMaxExponent);
  if (slope(end) > 0) return at(end);
  const Real width = power_of_two<Real>(-34);
  Real low = t * (1 - width), high = t * (1 + width);
  Real at_low = slope(low), at_high = slope(high);
  if (!(at_low > 0 && at_high < 0)) return minimize();
  // Regula falsi over a bracket of 1e-10 relative width, where the slope is all but straight.
  for (int i = 0; i < 3; ++i) {
    const Real middle = low + (high - low) * (at_low / (at_low - at_high));
    if (!(low < middle && middle < high)) break;
    const Real s = slope(middle);
    if (s > 0) {
      low = middle;
      at_low = s;
    } else {
      high = middle;
      at_high = s;
    }
  }
  return at(low + (high - low) * (at_low / (at_low - at_high)));
}

template <typename Real>
Real PairOracle<Real>::k_min(Real stop_below) const {
  constexpr Real kRange = 1e-9;  // K is flat at its minimum: good to the square of this
  Real low = power_of_two<Real>(-kMaxExponent), high = power_of_two<Real>(kMaxExponent);
  Real k = 1;
  while (high - low > kRange * low && k >= stop_below) {
    const Real t = square_root(low * high);
    const Vec3<Real> z = solve(t);
    k = 1 - t / (1 + t) * dot(d_, z);
    (quadratic(b_, z) > t * t * quadratic(a_, z) ? low : high) = t;
  }
  return k;
}

template class PairOracle<long double>;
#if LDBL_MANT_DIG < 113
template class PairOracle<Quad>;
#endif

OracleMinimum<Quad> oracle_minimum(const Ellipsoid& tool, const Ellipsoid& gaussian) {
  const Quad guess = PairOracle<long double>(tool, gaussian).minimize().t;
  return PairOracle<Quad>(tool, gaussian).minimize_near(guess);
}

LiteralPaper::LiteralPaper(const Ellipsoid& tool, const Ellipsoid& gaussian)
    : c_tool(Solid<Quad>(tool).center),
      c_gaussian(Solid<Quad>(gaussian).center),
      B_tool(shape_matrix(tool)),
      A_gaussian(shape_matrix(gaussian)) {}

Vec3<Quad> LiteralPaper::m(Quad lambda) const {
  Matrix e;
  for (std::size_t i = 0; i < 3; ++i) e[i] = lambda * B_tool[i] + (1 - lambda) * A_gaussian[i];
  const Vec3<Quad> w = lambda * times(B_tool, c_tool) + (1 - lambda) * times(A_gaussian, c_gaussian);
  return times(inverse(e), w);
}

Quad LiteralPaper::k(Quad lambda) const {
  const Vec3<Quad> w = lambda * times(B_tool, c_tool) + (1 - lambda) * times(A_gaussian, c_gaussian);
  return 1 - lambda * dot(c_tool, times(B_tool, c_tool)) -
         (1 - lambda) * dot(c_gaussian, times(A_gaussian, c_gaussian)) + dot(w, m(lambda));
}

}  // namespace palpate::test
