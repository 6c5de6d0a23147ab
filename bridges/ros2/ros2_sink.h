/// \file
/// NodeSink over DDS, compatible with ROS 2.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <node_sink.h>

#include "dds_entities.h"
#include "ros2_transport.h"

namespace palpate::ros2 {

/// \param world frame_id of data in the world frame \param participant must outlive the sink
std::unique_ptr<node::NodeSink> make_sink(Participant& participant, const Resolve& resolve, std::string world,
                                          const std::vector<node::SinkHand>& hands);

}  // namespace palpate::ros2
