/// \file
/// From a device's workspace to the world.
#pragma once

#include <palpate/geometry/pose.h>

namespace palpate {

/// Where a device is in the world, and how much larger the world is than its workspace:
///
///     x_world = offset + scale R x_device        q_world = R q_device H
///
/// A potential U of the world is felt as U / scale^2, so that a surface is as stiff in the hand as it is in
/// the world, in N/m:
///
///     F_device = R^T F_world / scale             T_device = R^T T_world / scale^2
struct WorkspaceMap {
  double scale = 1.0;  ///< metres of the world a metre of the hand's way. > 0
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< R, unit norm
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();              ///< of the device's origin. Unit: [m].
  /// H: orientation of the tool in the frame of the handle; identity until a clutch has turned the handle.
  Eigen::Quaterniond tool = Eigen::Quaterniond::Identity();

  bool operator==(const WorkspaceMap&) const = default;

  Pose to_world(const Pose& device) const {
    return {offset + scale * (rotation * device.position), rotation * device.orientation * tool};
  }
  Twist to_world(const Twist& device) const {
    return {scale * (rotation * device.linear), rotation * device.angular};
  }
  Pose to_device(const Pose& world) const {
    return {rotation.conjugate() * (world.position - offset) / scale,
            rotation.conjugate() * world.orientation * tool.conjugate()};
  }
  Wrench to_device(const Wrench& world) const {
    return {rotation.conjugate() * world.force / scale,
            rotation.conjugate() * world.torque / (scale * scale)};
  }
  /// Changes offset and H so that the tool is at `world` where the handle is at `device`.
  void attach(const Pose& world, const Pose& device) {
    offset += world.position - to_world(device).position;
    tool = ((rotation * device.orientation).conjugate() * world.orientation).normalized();
  }
  /// Of an energy of the world, in J.
  double to_device(double energy) const { return energy / (scale * scale); }
};

}  // namespace palpate
