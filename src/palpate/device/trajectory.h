/// \file
/// Recorded or scripted motion of the tool.
#pragma once

#include <string>
#include <vector>

#include <palpate/geometry/pose.h>

namespace palpate {

/// The tool at one instant, world frame.
struct TimedPose {
  double t = 0.0;  ///< Unit: [s].
  Pose pose;
};

/// In strictly increasing order of time.
using Trajectory = std::vector<TimedPose>;

/// Reads `t,x,y,z,qw,qx,qy,qz` (seconds, metres, tool in the world); further columns are ignored,
/// and without the four quaternion columns the orientation is the identity. Quaternions are
/// normalised.
/// \throws Error if the file is not such a table, time does not increase, or a quaternion is zero.
Trajectory read_trajectory(const std::string& path);

/// Writes what read_trajectory() reads. The file appears whole or not at all.
void write_trajectory(const Trajectory& trajectory, const std::string& path);

}  // namespace palpate
