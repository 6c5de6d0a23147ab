/// \file
/// Quaternions of norm 1, from numbers that are read.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace palpate {

/// q / |q|; q itself where its norm is 1 but for rounding, so that what was written and is read again stays
/// as it is to the last bit. \param q not zero
inline Eigen::Quaterniond normalized_once(const Eigen::Quaterniond& q) {
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();  // above that of normalized()
  return std::abs(q.squaredNorm() - 1.0) <= kRounding ? q : q.normalized();
}

}  // namespace palpate
