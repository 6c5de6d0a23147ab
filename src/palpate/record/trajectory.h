/// \file
/// Trajectories: recorded or scripted motion of the tool.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/geometry/pose.h>

namespace palpate {

/// The tool at one instant, world frame.
struct TimedPose {
  double t = 0.0;  ///< Unit: [s].
  Pose pose;       ///< X_WT
  /// User force measured at the handle, world frame, if the recording has it. Unit: [N].
  std::optional<Eigen::Vector3d> user_force;
};

/// Poses in strictly increasing order of time.
using Trajectory = std::vector<TimedPose>;

/// The pose of a trajectory at a time: linear interpolation of position and slerp of orientation between
/// neighbours, constant before the first and after the last pose. \pre not empty
Pose pose_at(const Trajectory& trajectory, double t);

/// Reads `t,x,y,z,qw,qx,qy,qz` (seconds, metres, tool in the world); without the four quaternion columns the
/// orientation is the identity. A measured user force in `ufx,ufy,ufz` is read if present; other columns are
/// ignored. Quaternions are normalised. \throws Error if the file is not such a table, time does not increase
/// by a nanosecond or more, a time or coordinate is beyond 1e12, or the norm of a quaternion differs from 1
/// by more than 0.1.
Trajectory read_trajectory(const std::string& path);

/// Writes `made`, TOML that says how the poses were made, as comment lines; then the poses as
/// read_trajectory() reads them. The file appears atomically.
void write_trajectory(const Trajectory& trajectory, const std::string& path, const std::string& made = {});

}  // namespace palpate
