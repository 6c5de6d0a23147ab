/// \file
/// The global similarity transform that registers a captured scene into the world.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/eigen_alignment.h>

namespace palpate {

/// x_W = scale * rotation * M * x_S + translation, the transform of paper eq. 3 (s, R_g, t), from the
/// captured frame S to the world frame W. M is 1, or diag(-1, 1, 1) for a capture that is a mirror image, as
/// tools whose frames are left-handed write them.
struct Similarity {
  double scale = 1.0;                                            ///< Unit: [m per captured unit], positive.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< Unit norm.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< Unit: [m].
  bool mirrored = false;

  /// Bounds on given scales, within which every product of the contact mathematics is finite.
  static constexpr double kScaleMin = 1e-9, kScaleMax = 1e9;

  bool operator==(const Similarity&) const = default;

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_S) const {
    return scale * (rotation * (mirrored ? mirror(x_S) : x_S)) + translation;
  }

  /// rotation * M: orthogonal, of determinant -1 if mirrored.
  Eigen::Matrix3d orthogonal() const {
    Eigen::Matrix3d Q = rotation.toRotationMatrix();
    if (mirrored) Q.col(0) = -Q.col(0);
    return Q;
  }

  Similarity inverse() const {
    Eigen::Quaterniond back = rotation.conjugate();
    Eigen::Vector3d origin = -(back * translation) / scale;
    if (mirrored) {  // (R M)^-1 = (M R^-1 M) M, where M R^-1 M negates y and z
      back.y() = -back.y();
      back.z() = -back.z();
      origin = mirror(origin);
    }
    return {1.0 / scale, back, origin, mirrored};
  }

 private:
  static Eigen::Vector3d mirror(const Eigen::Vector3d& x) { return {-x.x(), x.y(), x.z()}; }
};

}  // namespace palpate
