/// \file
/// Registry of the supported ROS 1 message and service types.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// A field or, with a value, a constant of a message.
struct RosField {
  std::string type;  ///< built-in ROS type, or the name of a RosType
  std::string name;
  bool is_array = false;  ///< of variable length: no type here has a fixed-length array
  std::string value = {};
};

/// A message type, or the request or response of a service.
struct RosType {
  std::string_view name;
  std::string_view text;  ///< as in ROS's .msg and .srv files, without comments
  std::vector<RosField> fields, constants;
};

/// Returns the type of a message ("std_msgs/Header"), or of a service request or response
/// ("std_srvs/TriggerRequest", "std_srvs/TriggerResponse"); null for an unknown type. The result has static
/// lifetime.
const RosType* find_ros_type(std::string_view name);

/// Converts a type name of either notation to that of ROS 1: std_msgs/msg/Header becomes std_msgs/Header.
std::string plain_type(std::string type);

}  // namespace palpate
