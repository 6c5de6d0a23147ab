/// \file
/// Rotations from directions and vectors.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

/// The smallest rotation that takes the direction of `from` to that of `to`, both of any length but zero;
/// between opposite directions, about some axis perpendicular to them. Accurate to 3e-8 close to opposite
/// directions, elsewhere to rounding. In closed form, whereas Eigen's FromTwoVectors() instantiates a
/// singular value decomposition for the opposite case.
inline Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized();
  const Eigen::Vector3d b = to.normalized();
  // (1 + cos, sin axis) is twice the cosine of the half angle times the quaternion.
  Eigen::Quaterniond q;
  q.w() = 1.0 + a.dot(b);
  q.vec() = a.cross(b);
  constexpr double kOpposite =
      1e-8;  // square root of the rounding error: either choice then has the same error
  if (q.norm() < kOpposite) {
    q.w() = 0.0;
    q.vec() = a.unitOrthogonal();
  }
  return q.normalized();
}

/// The rotation vector of q: its axis times its angle. Unit: [rad].
inline Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q);
  return turn.angle() * turn.axis();
}

/// Rotation from one orientation to another as a rotation vector, in the common frame of both. Unit: [rad].
inline Eigen::Vector3d turn_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  return rotation_vector(to * from.conjugate());
}

/// The rotation of a rotation vector. \param by Unit: [rad].
inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& by) {
  const double angle = by.norm();
  if (!(angle > 0.0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle));
}

}  // namespace palpate
