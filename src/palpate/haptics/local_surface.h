/// \file
/// Local surface model for remote rendering over a slow link.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace palpate {

/// A plane that the handle of the tool stays in front of, for the orientation of the proxy.
struct ContactPlane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    ///< of the handle, on the plane. Unit: [m].
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, outward
};

/// The surface around the tool as a few planes, for a spring between the handle and the nearest point in
/// front of all of them: gives the same force at the pose it was computed for, and nearby as far as the
/// surface is flat and the tool does not rotate.
struct LocalSurface {
  /// Three of a corner and one that is approached.
  static constexpr std::size_t kMost = 4;

  std::array<ContactPlane, kMost> planes;  ///< the first `count` are valid, in order of decreasing push
  std::size_t count = 0;
  double stiffness = 0.0;  ///< of the spring; 0 = the model has no local surface. Unit: [N/m].
  double damping = 0.0;    ///< along the force. Unit: [N s/m].
  double friction = 0.0;   ///< Coulomb's coefficient
};

}  // namespace palpate
