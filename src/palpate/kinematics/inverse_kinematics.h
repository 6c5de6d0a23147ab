/// \file
/// Joint positions for a pose of the TCP.
#pragma once

#include <optional>

#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {

/// What inverse_kinematics() takes for reached.
struct InverseOptions {
  double position = 1e-9, angle = 1e-9;  ///< Unit: [m], [rad].
  int steps = 100;                       ///< of Newton's method from one start
  int starts = 300;                      ///< the first is the seed, the others are drawn
  double length = 0.3;                   ///< a radian counts as much as so many metres. Unit: [m].
};

/// Joint positions within the limits that have the TCP at `target`: damped Gauss-Newton (Levenberg 1944) with
/// the limits as bounds of each step (least_in_box()), from `seed` and then from postures drawn within the
/// limits, always the same ones. \param target base's frame \param seed Shape: [joints]. \returns nothing
/// where no start comes there: it is out of reach, or all but. Takes nothing from the heap; not for a servo
/// tick: up to some ms.
std::optional<JointVector> inverse_kinematics(const SerialChain& chain, const Pose& target,
                                              const JointVector& seed, const InverseOptions& options = {});

}  // namespace palpate
