/// \file
/// The global similarity transform that registers a captured scene into the world.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

/// x_W = scale * rotation * x_S + translation, the transform of paper eq. 3 (s, R_g, t), from the
/// captured frame S to the world frame W.
struct Similarity {
  double scale = 1.0;                                            ///< Unit: [m per captured unit], positive.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< Unit norm.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< Unit: [m].

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_S) const {
    return scale * (rotation * x_S) + translation;
  }

  Similarity inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {1.0 / scale, back, -(back * translation) / scale};
  }
};

}  // namespace palpate
