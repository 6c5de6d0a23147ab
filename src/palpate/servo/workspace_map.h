/// \file
/// Map from a device's workspace to the world.
#pragma once

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_pose.h>

namespace palpate {

/// Placement of a device in the world, and the scale of the world relative to its workspace:
///
///     x_world = offset + scale R x_device        q_world = R q_device H
///
/// A potential U of the world is rendered as U / scale^2, so that the stiffness of a surface, in N/m, is the
/// same at the hand as in the world:
///
///     F_device = R^T F_world / scale             T_device = R^T T_world / scale^2
struct WorkspaceMap {
  double scale = 1.0;                                            ///< world metres per device metre. > 0
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< R, unit norm
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();              ///< of the device's origin. Unit: [m].
  /// H: orientation of the tool in the frame of the handle; identity until a clutch has turned the handle.
  Eigen::Quaterniond tool = Eigen::Quaterniond::Identity();

  bool operator==(const WorkspaceMap&) const = default;

  /// \returns X_WT of the tool T for the handle at X_DH
  Pose to_world(const DevicePose& X_DH) const {
    return {offset + scale * (rotation * X_DH.position), rotation * X_DH.orientation * tool};
  }
  /// \returns V_WT, expressed in W, for a handle that moves with V_DH, expressed in D
  Twist to_world(const Twist& V_DH) const {
    return {scale * (rotation * V_DH.linear), rotation * V_DH.angular};
  }
  /// \returns X_DH of the handle that holds the tool at X_WT
  DevicePose to_device(const Pose& X_WT) const {
    return {rotation.conjugate() * (X_WT.position - offset) / scale,
            rotation.conjugate() * X_WT.orientation * tool.conjugate()};
  }
  /// \param F_T_W on the tool, torque about the origin of T, expressed in W \returns F_H_D, on the handle,
  /// torque about the origin of H, expressed in D
  Wrench to_device(const Wrench& F_T_W) const {
    return {rotation.conjugate() * F_T_W.force / scale,
            rotation.conjugate() * F_T_W.torque / (scale * scale)};
  }
  /// Sets offset and H such that the tool is at X_WT with the handle at X_DH.
  void attach(const Pose& X_WT, const DevicePose& X_DH) {
    offset += X_WT.position - to_world(X_DH).position;
    tool = ((rotation * X_DH.orientation).conjugate() * X_WT.orientation).normalized();
  }
  /// Converts an energy in the world to one at the device. Unit: [J].
  double to_device(double energy) const { return energy / (scale * scale); }
};

}  // namespace palpate
