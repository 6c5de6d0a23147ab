/// \file
/// A tool, prepared for the SIMD query of one index: computed once a query, in double.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/collision/k_function.h>
#include <palpate/geometry/similarity.h>

namespace palpate {

/// A registration and an index's origin, prepared once: from the captured frame, relative to the origin, to
/// the world.
struct CapturedFrame {
  CapturedFrame(const Similarity& world_from_scene, const Eigen::Vector3d& origin);

  Eigen::Matrix3d world_from_captured;  ///< s R_g. Unit: [m per captured unit].
  Eigen::Matrix3d captured_from_world;  ///< its inverse
  Eigen::Vector3d origin;               ///< of the captured frame and of the index, in the world: s R_g o + t
  double scale;                         ///< s
  double size;                          ///< of the numbers that go into `origin`. Unit: [m].
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
struct SingleRounding {
  float constant, per_extent, per_volume;
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

/// The tool as the lanes want it. W and the boxes are in the captured frame, relative to the index's origin.
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
  Eigen::Matrix3f metric;  ///< W^T W
  BoxRounding box;         ///< of the gap between tool and box in lanes of single precision
  float reach_per_length;  ///< how far one captured unit reaches, at most, in tool radii
  float cull_slack;        ///< relative, of the squared distance in tool radii
  SingleRounding single;   ///< of K in lanes of single precision
  double rounding;         ///< of K in the lanes of double precision, where K is near 0
};

}  // namespace palpate
