/// \file
/// What is felt, in the shapes of ROS messages.
#pragma once

#include <span>
#include <string>

#include <palpate/geometry/pose.h>
#include <palpate/rosbridge/marker.h>
#include <palpate/rosbridge/message.h>

namespace palpate {

/// When, for a message. As ROS counts time.
struct Stamp {
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;

  /// The wall clock's.
  static Stamp now();
  double in_seconds() const { return static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds); }
  /// What clients send that stamp nothing.
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

/// A PoseStamped that was received.
struct StampedPose {
  Pose pose;
  Stamp stamp;
  std::string frame;
};

/// The stamp in a header of ROS 1 or 2; zero where there is none.
Stamp stamp_of(const Json& header);

/// Of ROS 1 or 2. \throws Refusal if a number is missing or not finite, or the quaternion is far from unit
/// length; it is normalised.
StampedPose pose_stamped(const Json& message);

}  // namespace palpate
