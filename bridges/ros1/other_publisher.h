/// \file
/// Detection of other publishers of a topic. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate::ros1 {

/// Returns the name of a node other than this one that publishes one of `topics`, according to the master;
/// empty if there is none. A node that has crashed stays registered: it counts only if its host accepts
/// connections on its port, or does not answer. \returns nothing if the master does not answer. \param topics
/// resolved names \pre ROS is initialised. Blocks.
std::optional<std::string> other_publisher(const std::vector<std::string>& topics);

}  // namespace palpate::ros1
