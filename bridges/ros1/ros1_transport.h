/// \file
/// Transport of a CrtkDevice over ROS 1.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <palpate/gateway/crtk_device.h>

namespace palpate {

/// \param prefix of the device's topics \param say implementation of CrtkTransport::say()
std::unique_ptr<CrtkTransport> make_ros1_transport(std::string prefix,
                                                   std::function<void(const std::string&)> say);

}  // namespace palpate
