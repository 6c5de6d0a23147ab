/// \file
/// Conversion of poses, wrenches and markers to and from ROS messages.
#pragma once

#include <span>
#include <string>

#include <palpate/geometry/pose.h>
#include <palpate/rosbridge/marker.h>
#include <palpate/rosbridge/message.h>

namespace palpate {

/// ROS time stamp of a message.
struct Stamp {
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;

  /// Returns the current wall-clock time.
  static Stamp now();
  double in_seconds() const { return static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds); }
  /// Returns whether the stamp is zero, as sent by clients that do not stamp.
  bool is_zero() const { return seconds == 0 && nanoseconds == 0; }
};

/// std_msgs/Header of ROS 1.
Json header(const Stamp& stamp, const std::string& frame, std::uint64_t seq);

Json to_json(const Eigen::Vector3d& v);     ///< geometry_msgs/Point, Vector3
Json to_json(const Eigen::Quaterniond& q);  ///< geometry_msgs/Quaternion
Json to_json(const Pose& pose);             ///< geometry_msgs/Pose
Json to_json(const Twist& twist);           ///< geometry_msgs/Twist
Json to_json(const Wrench& wrench);         ///< geometry_msgs/Wrench

Json to_json(const Json& header, const Marker& marker);  ///< visualization_msgs/Marker
/// visualization_msgs/MarkerArray.
Json marker_array(const Json& header, std::span<const Marker> markers);

/// A received PoseStamped.
struct StampedPose {
  Pose pose;
  Stamp stamp;
  std::string frame;
};

/// Returns the stamp in a ROS 1 or ROS 2 header; zero if there is none.
Stamp stamp_of(const Json& header);

/// Parses a PoseStamped of ROS 1 or 2. \throws Refusal if a number is missing or not finite, or the
/// quaternion is far from unit length; it is normalised.
StampedPose pose_stamped(const Json& message);

}  // namespace palpate
