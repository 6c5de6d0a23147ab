/// \file
/// Carries the messages of a CrtkDevice over ROS 1.
#pragma once

#include <memory>
#include <string>

#include <palpate/gateway/crtk_device.h>

namespace palpate {

/// \param prefix of the device's topics
std::unique_ptr<CrtkTransport> make_ros1_transport(std::string prefix);

}  // namespace palpate
