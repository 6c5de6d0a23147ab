/// \file
/// Position inverse kinematics: joint positions for a pose of the TCP.
#pragma once

#include <optional>

#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {

/// Tolerances and search effort of inverse_kinematics().
struct InverseOptions {
  double position = 1e-9, angle = 1e-9;  ///< Unit: [m], [rad].
  int steps = 100;                       ///< Newton steps per start
  int starts = 300;                      ///< the first is the seed, the others are random
  double length = 0.3;                   ///< metres that count as much as one radian. Unit: [m].
};

/// Joint positions within the limits that place the TCP at `target`: damped Gauss-Newton (Levenberg 1944)
/// with the limits as bounds of each step (least_in_box()), from `seed` and then from random postures within
/// the limits, the same ones in every call. \param target base's frame \param seed Shape: [joints]. \returns
/// nothing if no start converges: the target is out of reach, or nearly so. Allocates memory and takes up to
/// some ms, hence not for a servo tick.
std::optional<JointVector> inverse_kinematics(const SerialChain& chain, const Pose& target,
                                              const JointVector& seed, const InverseOptions& options = {});

}  // namespace palpate
