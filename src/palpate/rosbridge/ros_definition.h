/// \file
/// ROS 1 definitions of the published message types, and ROS 1 serialization.
#pragma once

#include <string>

#include <palpate/rosbridge/message.h>

namespace palpate {

/// Returns the definition of a type and of all nested types, in the format of `rosmsg` and rosapi; empty for
/// an unknown type.
std::string ros_definition(const std::string& type);

/// Serializes `message` as ROS 1 does: fields in the order of the definition, little-endian. Missing fields
/// are zero or empty. \pre ros_definition(type) is not empty
std::string ros_bytes(const std::string& type, const Json& message);

}  // namespace palpate
