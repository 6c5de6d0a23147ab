/// \file
/// Where a simulated hand wants to be.
#pragma once

#include <palpate/device/simulated_device.h>
#include <palpate/record/trajectory.h>

namespace palpate {

/// Along the trajectory from its first pose to its last, and back, for ever: it goes on where it is wherever
/// the trajectory is at rest at both ends. \pre not empty
HandPath to_and_fro(Trajectory trajectory);

/// The tremor of a hand that is at rest: some 0.1 mm at 8 to 12 Hz, in every direction, added to where it
/// wants to be.
HandPath with_tremor(HandPath path, double amplitude);

}  // namespace palpate
