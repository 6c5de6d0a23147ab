/// \file
/// Types of messages and services of ROS 1 that are spoken here.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// A field or, with a value, a constant of a message.
struct RosField {
  std::string type;  ///< of ROS's own, or the name of a RosType
  std::string name;
  bool is_array = false;  ///< of any length: no type here has one of a fixed length
  std::string value = {};
};

/// A message, or a half of a service.
struct RosType {
  std::string_view name;
  std::string_view text;  ///< as ROS's own .msg and .srv files have it, without comments
  std::vector<RosField> fields, constants;
};

/// Of a message ("std_msgs/Header"), or the half of a service ("std_srvs/TriggerRequest",
/// "std_srvs/TriggerResponse"). Null: it is not known here. What it points to stays.
const RosType* find_ros_type(std::string_view name);

/// As ROS 1 writes the name of a type, of either notation: std_msgs/Header of std_msgs/msg/Header.
std::string plain_type(std::string type);

}  // namespace palpate
