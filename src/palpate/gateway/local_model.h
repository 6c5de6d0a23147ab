/// \file
/// The surface about the tool, for a device at the far end of a network that makes the force by itself.
#pragma once

#include <vector>

#include <Eigen/Core>

#include <palpate/haptics/local_surface.h>
#include <palpate/servo/servo_tick.h>

namespace palpate {

/// What a tick felt, in the device's frame. docs/gateway.md says how it is rendered.
struct LocalModel {
  LocalSurface surface;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the handle that it was made for. Unit: [m].
  double share = 0.0;  ///< of the force that the governor lets through now, in [0, 1]
};

/// Takes nothing from the heap.
LocalModel local_model_of(const TickRecord& tick);

/// As numbers, which ROS has a message for (std_msgs/Float64MultiArray): the stamp in whole seconds and
/// nanoseconds, position (3), stiffness, damping, friction and share, then point and normal of each plane.
/// \param stamp of the pose it answers. Unit: [s].
std::vector<double> numbers_of(const LocalModel& model, double stamp);
inline constexpr std::size_t kLocalModelHead = 9;   ///< numbers before the planes
inline constexpr std::size_t kLocalModelPlane = 6;  ///< numbers of a plane

}  // namespace palpate
