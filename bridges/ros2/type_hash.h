/// \file
/// Hashes of message types, as ROS 2 tells them from Iron on.
#pragma once

#include <string_view>

#include <dds/dds.h>

namespace palpate::ros2 {

/// The user data of a reader or writer of `type` ("geometry_msgs::msg::dds_::PoseStamped_"): nodes that do
/// not find it there say so. Leaves out what is not known.
void set_type_hash(dds_qos_t& qos, std::string_view type);

}  // namespace palpate::ros2
