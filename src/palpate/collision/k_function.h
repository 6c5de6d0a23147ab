/// \file
/// Overlap test of two ellipsoids: the function K of paper eqs. 5-6 (after Gilitschenski and Hanebeck), in a
/// form free of cancellation, and its minimum.
///
/// With tool covariance B, Gaussian covariance A and d = c_tool - c_gaussian, eqs. 5-6 are
///
///     K(l) = 1 - l (1-l) d^T [ (1-l) B + l A ]^-1 d,      l in [0, 1] the paper's lambda.
///
/// K is convex, K(0) = K(1) = 1, and the solids overlap iff min K > 0; 1 - min K is the
/// Perram-Wertheim contact function. Whitening by the tool (W B W^T = I, d' = W d, L = W * axes
/// with columns l1 l2 l3) and t = l/(1-l) turn it into
///
///     K = 1 - t (p0 + p1 t + p2 t^2) / [ (1+t) (1 + e1 t + e2 t^2 + e3 t^3) ]
///     p0 = |d'|^2   p1 = sum |li x d'|^2   p2 = sum_{i<j} ((li x lj) . d')^2
///     e1 = sum |li|^2   e2 = sum_{i<j} |li x lj|^2   e3 = det(L)^2
///
/// Every coefficient is a sum of squares, so flat and needle-shaped Gaussians, down to a semi-axis
/// of exactly zero, lose no digits.
#pragma once

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// The tool, preprocessed once per query.
struct WhitenedTool {
  /// \pre all semi-axes of `tool` are positive.
  explicit WhitenedTool(const Ellipsoid& tool);

  Ellipsoid ellipsoid;  ///< the tool itself, world frame
  Eigen::Matrix3d W;    ///< world to whitened: the tool becomes the unit sphere. Unit: [1/m].
};

/// K for one pair.
struct KFunction {
  /// \throws nothing, allocates nothing; any thread.
  KFunction(const WhitenedTool& tool, const Ellipsoid& gaussian);
  /// \param distance d' \param l L
  KFunction(const Eigen::Vector3d& distance, const Eigen::Matrix3d& l);

  Eigen::Vector3d d;  ///< d' = W (c_tool - c_gaussian), in tool radii
  Eigen::Matrix3d L;  ///< W * gaussian.axes, in tool radii
  double p0, p1, p2;
  double e1, e2, e3;

  /// K at lambda in [0, 1].
  double operator()(double lambda) const;
};

/// The range of ln t: e^-120 is far below the resolution of any size ratio that kMaxExtent admits,
/// and its cube still fits a double. Beyond it, lambda is 0 or 1.
inline constexpr double kMaxLogT = 120.0;

/// The minimum of K.
struct KMinimum {
  double k_min;   ///< in (-inf, 1]; the solids overlap iff it is positive
  double lambda;  ///< argmin; 0.5 if the centres coincide (K is then 1 everywhere)
  /// ln(lambda / (1 - lambda)): resolves lambda near 0 or 1 exactly, as size ratios require. Finite; at the
  /// end of its range if the minimum is at lambda = 1 (a point or a disc seen end on).
  double log_t;
};

/// Minimises K by Newton's method on d ln(1-K) / d ln t inside a bracket, and does not stop before
/// the slope changes its sign, so that it cannot fail. Worst |dK_min| against 113-bit arithmetic,
/// relative to max(1, 1-K_min): 1e-12 over the hard cases of tests/collision/k_function_oracle_test.cpp
/// (needles, discs of no thickness, size ratios to 1e8), which enforce it. Where the input itself does
/// not determine K to that, as for a flat Gaussian of a kilometre under a tool of 2 cm, the error stays
/// inside the bound 2 lambda (sqrt(f) |dd'| + f |dL|), f = 1 - K, of the rounding of d' and L.
KMinimum minimize(const KFunction& k);

/// y = (I + t L L^T)^-1 d', by the adjugate: no inverse, no cancellation, L may be singular. The
/// gradient of K, the contact normal and the contact point all follow from y.
Eigen::Vector3d solve_whitened(const KFunction& k, double log_t);

}  // namespace palpate
