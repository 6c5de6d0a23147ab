/// \file
/// A node of ROS 1, without ROS headers: these do not compile as C++20.
#pragma once

#include <vector>

#include <node_parameter.h>

namespace palpate::ros1 {

/// Initialises ROS with remappings and private names (`_NAME:=VALUE`), waits for a master, and reads all
/// private parameters. Signals stay as they are. \throws std::runtime_error for an argument that ROS does not
/// know, no ROS_MASTER_URI, or a parameter that is neither a number, text, true or false nor an array of
/// these.
std::vector<node::NodeParameter> init_node(int& argc, char** argv);

/// False once the node has been asked to end (`rosnode kill`, another of its name).
bool is_up();

}  // namespace palpate::ros1
