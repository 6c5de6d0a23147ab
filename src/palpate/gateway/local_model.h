/// \file
/// Local surface model around the tool, for a remote device that computes the force itself.
#pragma once

#include <vector>

#include <Eigen/Core>

#include <palpate/haptics/local_surface.h>
#include <palpate/servo/servo_tick.h>

namespace palpate {

/// Local contact surface of a tick, in the device's frame. docs/gateway.md describes how to render it.
struct LocalModel {
  LocalSurface surface;
  Eigen::Vector3d position =
      Eigen::Vector3d::Zero();  ///< of the handle for which it was computed. Unit: [m].
  double share = 0.0;           ///< fraction of the force that the governor currently passes, in [0, 1]
};

/// Returns the local model of a tick. Does not allocate.
LocalModel local_model_of(const TickRecord& tick);

/// Serializes a local model for std_msgs/Float64MultiArray: the stamp in whole seconds and nanoseconds,
/// position (3), stiffness, damping, friction and share, then point and normal of each plane.
/// \param stamp of the pose it answers. Unit: [s].
std::vector<double> numbers_of(const LocalModel& model, double stamp);
inline constexpr std::size_t kLocalModelHead = 9;   ///< numbers before the planes
inline constexpr std::size_t kLocalModelPlane = 6;  ///< numbers of a plane

}  // namespace palpate
