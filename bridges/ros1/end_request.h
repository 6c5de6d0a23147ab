/// \file
/// Requests to end this node (`rosnode kill`, another node of the same name). Includes no ROS headers, which
/// do not compile as C++20.
#pragma once

#include <functional>

namespace palpate::ros1 {

/// Has `asked` called, instead of the shutdown of ROS, when this node is asked to end: roscpp would drop all
/// publications at once, so that the last wrench that the driver gets is that of the contact. The caller
/// takes the force down, and then ends the program. \param asked called on a thread of ROS, each time; must
/// not block \pre ROS is started. Call it once per process.
void on_end_request(const std::function<void()>& asked);

}  // namespace palpate::ros1
