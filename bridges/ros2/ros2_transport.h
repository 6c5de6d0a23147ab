/// \file
/// Transport of a CrtkDevice over DDS, compatible with ROS 2.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <palpate/gateway/crtk_device.h>

#include "dds_entities.h"

namespace palpate::ros2 {

/// Returns the remapped name of a topic; see Names.
using Resolve = std::function<std::string(const std::string& name)>;

/// Subscribes PREFIX/measured_cp, measured_cv and palpate/echoed, publishes PREFIX/spatial/servo_cf,
/// body/servo_cf, palpate/echo and palpate/local_model, from start() to stop(). A std_msgs/Header has no
/// sequence number in ROS 2: the number of an echo is its frame_id. \param participant must outlive the
/// transport; null: it creates its own
std::unique_ptr<CrtkTransport> make_transport(std::string prefix, Say say, Resolve resolve,
                                              Participant* participant = nullptr);

}  // namespace palpate::ros2
