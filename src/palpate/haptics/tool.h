/// \file
/// What the hand holds.
#pragma once

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// A tool of one ellipsoid, centred on the tool frame with its axes along the frame's.
struct Tool {
  Eigen::Vector3d semi_axes{0.02, 0.02, 0.04};  ///< Unit: [m]. Positive.

  /// The tool's solid at `pose`.
  Ellipsoid at(const Pose& pose) const { return Ellipsoid::from_semi_axes(pose, semi_axes); }
};

}  // namespace palpate
