/// \file
/// Initialisation of a ROS 1 node. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <vector>

#include <node_parameter.h>

namespace palpate::ros1 {

/// Initialises ROS with remappings and private names (`_NAME:=VALUE`), waits for a master, and reads all
/// private parameters. Signal handlers are not changed. \throws std::runtime_error for an argument that ROS
/// does not know, a missing ROS_MASTER_URI, or a parameter that is not a number, text, boolean or array of
/// these.
std::vector<node::NodeParameter> init_node(int& argc, char** argv);

/// Starts the threads of ROS, which inherit the scheduling of the calling one: poses arrive on them.
void start_node();

/// Returns false once the node has been asked to end (`rosnode kill`, another node of the same name). Its
/// topics remain until the program ends, so that the fall of the force reaches the driver.
bool is_up();

}  // namespace palpate::ros1
