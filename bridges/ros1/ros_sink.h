/// \file
/// What a node shows on ROS 1, without ROS headers: these do not compile as C++20.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <node_sink.h>

namespace palpate::ros1 {

/// Serves the services of `hands` anew where the master has been started again. \param world frame_id of what
/// is in the world \pre init_node()
std::unique_ptr<node::NodeSink> make_sink(std::string world, std::vector<node::SinkHand> hands);

}  // namespace palpate::ros1
