/// \file
/// Target paths of a simulated hand.
#pragma once

#include <palpate/device/simulated_device.h>
#include <palpate/record/trajectory.h>

namespace palpate {

/// Follows the trajectory from its first pose to its last and back, for ever: the motion is smooth if the
/// trajectory is at rest at both ends. \pre not empty
HandPath to_and_fro(Trajectory trajectory);

/// Adds the tremor of a resting hand to a path: about 0.1 mm at 8 to 12 Hz, in every direction.
HandPath with_tremor(HandPath path, double amplitude);

}  // namespace palpate
