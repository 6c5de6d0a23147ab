#include <palpate/collision/exact_k.h>

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace palpate {
namespace {

#if LDBL_MANT_DIG >= 113
using Quad = long double;
#else
__extension__ typedef __float128 Quad;
#endif

struct Vec {
  Quad x, y, z;
};

Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(Quad s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
Quad dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Quad square(Quad v) { return v * v; }
Quad square(const Vec& v) { return dot(v, v); }

/// Semi-axes of a Gaussian in the captured frame.
struct Axes {
  Vec column[3];

  Axes(const GaussianBlock& block, std::size_t lane) {
    const auto length = [&](std::size_t axis) {
      return static_cast<Quad>(block.length_high[axis][lane]) + block.length_low[axis][lane];
    };
    const Quad w = block.rotation[0][lane], x = block.rotation[1][lane], y = block.rotation[2][lane],
               z = block.rotation[3][lane];
    const Quad s = 2 / (w * w + x * x + y * y + z * z);
    column[0] = length(0) * Vec{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)};
    column[1] = length(1) * Vec{s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)};
    column[2] = length(2) * Vec{s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)};
  }
};

/// KFunction: K = 1 - f, f = t (p0 + p1 t + p2 t^2) / [ (1+t) (1 + e1 t + e2 t^2 + e3 t^3) ].
struct Coefficients {
  Quad p[3], e[4];

  Coefficients(const Vec& d, const Vec (&l)[3]) {
    const Vec c01 = cross(l[0], l[1]), c12 = cross(l[1], l[2]), c20 = cross(l[2], l[0]);
    p[0] = square(d);
    p[1] = square(cross(l[0], d)) + square(cross(l[1], d)) + square(cross(l[2], d));
    p[2] = square(dot(c01, d)) + square(dot(c12, d)) + square(dot(c20, d));
    e[0] = 1;
    e[1] = square(l[0]) + square(l[1]) + square(l[2]);
    e[2] = square(c01) + square(c12) + square(c20);
    e[3] = square(dot(c01, l[2]));
  }
};

/// f, g = d ln f / d ln t and h = dg / d ln t.
struct Slope {
  Quad f, g, h;

  Slope(const Coefficients& k, Quad t) {
    const Quad p[3] = {k.p[0], k.p[1] * t, k.p[2] * t * t};
    const Quad e[4] = {k.e[0], k.e[1] * t, k.e[2] * t * t, k.e[3] * t * t * t};
    const Quad P = p[0] + p[1] + p[2], E = e[0] + e[1] + e[2] + e[3], rest = 1 / (1 + t);
    const Quad p_mean = (p[1] + 2 * p[2]) / P, e_mean = (e[1] + 2 * e[2] + 3 * e[3]) / E;
    f = t * rest * P / E;
    g = rest + p_mean - e_mean;
    h = (p[1] + 4 * p[2]) / P - p_mean * p_mean - t * rest * rest -
        ((e[1] + 4 * e[2] + 9 * e[3]) / E - e_mean * e_mean);
  }
};

Coefficients coefficients_of(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool) {
  const auto whiten = [&](const Vec& v) {
    const auto row = [&](int i) { return Vec{tool.W(i, 0), tool.W(i, 1), tool.W(i, 2)}; };
    return Vec{dot(row(0), v), dot(row(1), v), dot(row(2), v)};
  };
  const Axes axes(block, lane);
  const Vec from{block.position[0][lane], block.position[1][lane], block.position[2][lane]};
  const Vec to{tool.center[0], tool.center[1], tool.center[2]};
  const Vec l[3] = {whiten(axes.column[0]), whiten(axes.column[1]), whiten(axes.column[2])};
  return {whiten(to - from), l};
}

}  // namespace

double exact_k_min(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, double log_t) {
  constexpr int kMostSteps = 30;       // two or three suffice from the minimum in double
  constexpr double kExcess = 0x1p-53;  // largest relative excess of K over its minimum
  const Coefficients k = coefficients_of(block, lane, tool);
  Quad t = std::exp(log_t), value = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Slope at(k, t);
    value = 1 - at.f;
    if (value <= 0) break;
    // K is convex in lambda, see minimize() of contact_lanes-inl.h.
    const Quad fall = at.g > 0 ? at.f * at.g * (1 + t) / t : -at.f * at.g * (1 + t);
    if (fall <= kExcess * value) break;
    const Quad newton = at.h < 0 ? -at.g / at.h : at.g > 0 ? Quad{1} : Quad{-1};
    const Quad s = std::clamp(newton, Quad{-1}, Quad{1});
    t *= 1 + s + s * s / 2;
  }
  return static_cast<double>(value);
}

}  // namespace palpate
