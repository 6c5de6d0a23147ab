/// \file
/// Rotations from directions.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

/// The smallest rotation that takes the direction of `from` to that of `to`, both of any length but zero;
/// between opposite directions about some axis across them. To 3e-8 close to those, elsewhere to rounding. In
/// closed form, where Eigen's FromTwoVectors() instantiates a singular value decomposition for the sake of
/// the opposite ones.
inline Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized();
  const Eigen::Vector3d b = to.normalized();
  // (1 + cos, sin axis) is twice the cosine of the half angle times the quaternion.
  Eigen::Quaterniond q;
  q.w() = 1.0 + a.dot(b);
  q.vec() = a.cross(b);
  constexpr double kOpposite =
      1e-8;  // root of the rounding: taking them as opposite, or not, then errs alike
  if (q.norm() < kOpposite) {
    q.w() = 0.0;
    q.vec() = a.unitOrthogonal();
  }
  return q.normalized();
}

}  // namespace palpate
