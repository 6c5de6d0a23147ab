/// \file
/// Definitions of the message types of ROS 1 that are published here, and messages in its own encoding.
#pragma once

#include <string>

#include <palpate/rosbridge/message.h>

namespace palpate {

/// The definition of a type and of all types in it, as `rosmsg` and rosapi write it. Empty: it is not known
/// here.
std::string ros_definition(const std::string& type);

/// `message` as ROS 1 encodes it: fields in the order of the definition, little-endian. What it lacks is zero
/// or empty. \pre ros_definition(type) is not empty
std::string ros_bytes(const std::string& type, const Json& message);

}  // namespace palpate
