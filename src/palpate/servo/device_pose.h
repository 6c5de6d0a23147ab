/// \file
/// The pose of a handle in the frame of its device.
#pragma once

#include <cmath>

#include <palpate/geometry/pose.h>

namespace palpate {

/// X_DH: the pose of the handle H in the frame D of the device. A type distinct from Pose, so that it cannot
/// be passed where a pose in the world W is expected; WorkspaceMap converts between the two.
struct DevicePose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the handle's origin, in D. Unit: [m].
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< Unit norm, H to D.

  DevicePose() = default;
  /// Both measured and expressed in D.
  DevicePose(const Eigen::Vector3d& p_DH, const Eigen::Quaterniond& q_DH)
      : position(p_DH), orientation(q_DH) {}
  /// \param X_DH pose in D already: from a driver or its simulation
  explicit DevicePose(const Pose& X_DH) : position(X_DH.position), orientation(X_DH.orientation) {}

  /// The same numbers as a Pose, for code that works in D throughout.
  Pose in_device_frame() const { return {position, orientation}; }

  /// Finite, and its orientation a unit quaternion but for rounding and drivers in single precision.
  bool is_valid() const {
    constexpr double kUnitTolerance = 1e-3;
    return position.allFinite() && std::abs(orientation.norm() - 1.0) <= kUnitTolerance;
  }

  bool operator==(const DevicePose&) const = default;
};

}  // namespace palpate
