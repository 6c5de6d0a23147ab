/// \file
/// A tool, preprocessed for the SIMD query of one index: once per query, in double precision.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/collision/k_function.h>
#include <palpate/geometry/similarity.h>

namespace palpate {

/// The transform from the captured frame, relative to an index's origin, to the world, precomputed from the
/// registration.
struct CapturedFrame {
  CapturedFrame(const Similarity& world_from_scene, const Eigen::Vector3d& origin);

  Eigen::Matrix3d world_from_captured;  ///< s R_g. Unit: [m per captured unit].
  Eigen::Matrix3d captured_from_world;  ///< its inverse
  Eigen::Vector3d origin;               ///< of the captured frame and of the index, in the world: s R_g o + t
  double scale;                         ///< s
  double size;                          ///< magnitude of the terms summed in `origin`. Unit: [m].
};

/// Bound of the relative error of f = 1 - K in lanes of single precision, where f is near 1 or above:
///
///     |f_float - f| / f  <=  constant + per_extent A + per_volume A^3 / E,   A = 1 + t e1
///
/// with t, e1 and E = 1 + e1 t + e2 t^2 + e3 t^3 of k_function.h. It adds up, with u = 2^-24, kappa = |W|_F
/// a_max and beta = 2 u^2 |c| |W|_F (the tool's centre is two floats):
///
///   1. d' and L are rounded: |dd'| <= 6 kappa u |d'| + beta, |dL| <= 24 kappa u |L|. At fixed lambda,
///      f = lambda (1-lambda) d'^T M^-1 d' with M = (1-lambda) I + lambda L L^T changes by at most
///      2 sqrt(lambda f) |dd'| + 2 sqrt(t) f |dL|, as M bounds both M^-1 d' and L^T M^-1 d'. With
///      f >= lambda p0 / A and sqrt(t e1), sqrt(A) <= A the relative change is <= 36 kappa u A + 2 beta.
///   2. The coefficients are rounded: each is a sum of squares of sums of products, so that
///      |dp1| <= 13 u e1 p0, |dp2| <= 6 u e1^2 p0, |de2| <= 5 u e1^2, |de3| <= u e1^3. With P >= E p0 / A the
///      numerator is off by 13 u A^3 / E + 4 u and the denominator by 3 u A^3 / E + 6 u.
///   3. The comparison's own products: 4 u.
///
/// Doubled, for the second order that this leaves out.
///
/// Where the coefficients were computed in double and rounded once, they are off by u each, as they are not
/// negative. A term of P or E has at most three products (3 u), their sums at most three additions of numbers
/// that are not negative (3 u); P, E, t P, 1 + t and their product add 4 u and the comparison's product u.
/// Numerator and denominator together: at most 20 u; doubled. Besides, they have the error of DoubleRounding,
/// whose |d'| sqrt(lambda / f) and sqrt(e1 X) are at most sqrt(A) anywhere.
struct SingleRounding {
  float constant, per_extent, per_volume;
};

/// Bound of the relative error of f = 1 - K in double, in lanes or not, where f is near 1 or above:
///
///     ((f_double - f) / f)^2  <=  r0^2 + x (max(0, -g) + g_0 + 128 x),    x = per_extent t e1
///     r0^2 = constant + per_distance p0 + per_extent e1
///
/// with t, p0, e1 and g = d ln f / d ln t of k_function.h, and g_0 the rounding of g. W and the tool's centre
/// are taken as they are. It adds up, with u = 2^-53, kappa = |W|_F a_max and eta = a_max a_mid / a_min^2 of
/// the tool's semi-axes:
///
///   1. With y = (I + t L L^T)^-1 d' it is f = lambda d' . y, and from the slope of f follow
///      |y|^2 = (f / lambda) (lambda + g) and t |L^T y|^2 = (f / lambda) (1 - lambda - g). Both sides are at
///      most f / lambda.
///   2. d' is rounded, |dd'| <= 6 kappa u |d'|, which changes f by 2 lambda |y| |dd'|: 12 kappa u |d'|.
///   3. L is rounded, column by column |dl| <= 32 kappa u |l|, which changes f by
///      2 lambda t |y| |L^T y| |dL|: 64 kappa u sqrt(e1 X) with X = t (lambda + g) (1 - lambda - g). Below
///      the minimum, where g >= 0, t (1 - lambda - g) <= lambda + g and X <= 1; beyond it X <= 1 + t |g|.
///   4. The coefficients are rounded. A Gaussian's axes are perpendicular, so that |li| |lj| <= eta |li x lj|
///      and |l1| |l2| |l3| <= eta |det L|: the error of E is at most (14 eta + 12) u, and of P, since
///      t e1, t^2 e2 <= E, p1 t, p2 t^2 <= P and E / P = lambda / f, (14 eta + 8) u |d'| + 12 u. What follows
///      adds 10 u.
///   5. All of that shifts g, which is made of means of the powers of t, by ten times as much at most. Taken
///      as 16 r, that is another 16 x r in 3, and 16 x r <= r^2 / 2 + 128 x^2.
///
/// In all (14 eta + 34) u + (22 eta + 12 kappa) u |d'| + 64 kappa u sqrt(e1 X); three for the square of a sum
/// of three, two for 5, and doubled for the second order that this leaves out. Near the minimum it grows
/// as the size ratio of the pair does, and no more: so does the true error, of a flat Gaussian that is
/// touched off its centre (tests/collision/simd_oracle_test.cpp).
struct DoubleRounding {
  double constant, per_distance, per_extent;
};

/// Bound of the error of  m^T M m - |M m| . h - 2 sqrt(m^T M m)  in lanes of single precision, where m = (low
/// - c) + (high - c) and h = (high - c) - (low - c) for a box, c the tool's centre and M = W^T W:
///
///     constant + per_square (|m|^2 + |h|^2)
///
/// With u = 2^-24, N = |W|_F, s^2 = |m|^2 + |h|^2 and a = u N |c|, the float that stands for c being off by u
/// |c|:
///
///   1. |dm|, |dh| <= 3 u s + 2 u |c|;  |d(M m)| <= N^2 (7 u s + 2 u |c|), M rounded and three products a
///   row;
///   2. m^T M m and |M m| . h are each off by at most N^2 (13 u s^2 + 4 u |c| s), their difference by another
///      2 u N^2 s^2; 8 u N^2 |c| s <= 4 a (1 + N^2 s^2);
///   3. where the difference exceeds twice the root, the root exceeds 2: its double is off by half of what
///      m^T M m is.
///
/// In all 5 a and N^2 (35 u + 5 a), and the comparison's own roundings; nearly doubled.
struct BoxRounding {
  float constant, per_square;
};

/// The tool in the form that the lanes use. W and the boxes are in the captured frame, relative to the
/// index's origin.
struct ToolFrame {
  /// \pre the semi-axes of `tool` (world frame) are positive and all of it is finite.
  ToolFrame(const Ellipsoid& tool, const CapturedFrame& frame);

  // In double, for the contacts.
  WhitenedTool world;      ///< of the tool itself
  Eigen::Matrix3d W;       ///< captured frame to whitened: world.W s R_g. Unit: [1/captured unit].
  Eigen::Vector3d center;  ///< captured frame
  double scale;            ///< of the registration. Unit: [m per captured unit].

  // In single precision, for finding candidates.
  Eigen::Vector3f low, high;    ///< box of the tool, rounded outwards, never infinite
  Eigen::Matrix3f W_float;      ///< W
  Eigen::Vector3f center_high;  ///< center = center_high + center_low + 2^-48 |center|
  Eigen::Vector3f center_low;
  Eigen::Matrix3f metric;   ///< W^T W
  BoxRounding box;          ///< of the gap between tool and box in lanes of single precision
  float reach_per_length;   ///< upper bound of one captured unit in tool radii
  float cull_slack;         ///< relative, of the squared distance in tool radii
  SingleRounding single;    ///< of K in lanes of single precision
  SingleRounding rounded;   ///< of K in lanes of single precision whose coefficients come from double
  DoubleRounding rounding;  ///< of K in double
};

}  // namespace palpate
