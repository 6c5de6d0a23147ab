/// \file
/// Unit quaternions: a check, and the normalisation of those that were read from files.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace palpate {

/// q / |q|; q unchanged if its norm is 1 up to rounding, so that a quaternion that is written and read back
/// is bitwise identical. \param q not zero
inline Eigen::Quaterniond normalized_once(const Eigen::Quaterniond& q) {
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();  // above that of normalized()
  return std::abs(q.squaredNorm() - 1.0) <= kRounding ? q : q.normalized();
}

/// True if the norm of q is 1 up to what products of rotations accumulate; false for NaN.
inline bool has_unit_norm(const Eigen::Quaterniond& q) {
  constexpr double kTolerance = 1e-6;  // a rotation that scales lengths by this is not noticed
  return std::abs(q.norm() - 1.0) <= kTolerance;
}

}  // namespace palpate
