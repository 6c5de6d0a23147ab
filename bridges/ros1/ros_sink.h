/// \file
/// NodeSink for ROS 1. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <node_sink.h>

namespace palpate::ros1 {

/// Makes a sink that registers the services of `hands` again after the master has restarted.
/// \param world frame_id of data in the world frame \pre init_node()
std::unique_ptr<node::NodeSink> make_sink(std::string world, std::vector<node::SinkHand> hands);

}  // namespace palpate::ros1
