/// \file
/// Hashes of message types, as announced by ROS 2 since Iron.
#pragma once

#include <string_view>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Sets the type hash of `type` ("geometry_msgs::msg::dds_::PoseStamped_") as user data of a reader or
/// writer: ROS 2 nodes warn if it is missing. Does nothing for an unknown type.
void set_type_hash(dds_qos_t& qos, std::string_view type);

}  // namespace palpate::ros2
