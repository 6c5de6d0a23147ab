/// \file
/// What a node shows over DDS, as ROS 2 does.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <node_sink.h>

#include "dds_entities.h"
#include "ros2_transport.h"

namespace palpate::ros2 {

/// \param world frame_id of what is in the world \param participant must outlive it
std::unique_ptr<node::NodeSink> make_sink(Participant& participant, const Resolve& resolve, std::string world,
                                          const std::vector<node::SinkHand>& hands);

}  // namespace palpate::ros2
