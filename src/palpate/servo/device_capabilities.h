/// \file
/// What a haptic device can do.
#pragma once

#include <string>

namespace palpate {

/// From the maker's data sheet. All are upper bounds: nothing sends more, whatever a force model asks for.
struct DeviceCapabilities {
  std::string name;
  double force_max = 0.0;      ///< that it can hold for a while. Unit: [N]. > 0
  double torque_max = 0.0;     ///< 0 if it has no motors for the orientation. Unit: [N m].
  double stiffness_max = 0.0;  ///< of a wall that it shows without buzzing. Unit: [N/m].
  double damping_max = 0.0;    ///< Unit: [N s/m].
  double damping = 0.0;        ///< its own, which makes walls stable. Unit: [N s/m].
  double workspace = 0.0;      ///< radius of the largest ball in it. Unit: [m].
  double rate = 1000.0;        ///< of its readings. Unit: [Hz].
};

}  // namespace palpate
