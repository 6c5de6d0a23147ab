/// \file
/// What a hand at the other end of a slow link needs to feel a surface before the next answer comes.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace palpate {

/// A plane that the handle of the tool stays before, in the orientation that the proxy has.
struct ContactPlane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    ///< of the handle, on the plane. Unit: [m].
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, outward
};

/// The surface about the tool as a few planes, for a spring between the handle and the nearest place before
/// all of them: the same force where it was made, and near it as far as the surface is flat and the tool does
/// not turn.
struct LocalSurface {
  /// A corner has three, and one comes.
  static constexpr std::size_t kMost = 4;

  std::array<ContactPlane, kMost> planes;  ///< the first `count`; those that are pushed hardest first
  std::size_t count = 0;
  double stiffness = 0.0;  ///< of the spring; 0: the model has no such surface. Unit: [N/m].
  double damping = 0.0;    ///< along the force. Unit: [N s/m].
  double friction = 0.0;   ///< Coulomb's coefficient
};

}  // namespace palpate
