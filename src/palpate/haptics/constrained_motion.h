/// \file
/// The rigid motion nearest to a wanted one that does not enter any of a few planes.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <palpate/haptics/surface_fit.h>

namespace palpate {

/// A small motion of a rigid body: of its handle, and about it. World frame.
struct Motion {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< Unit: [m].
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector. Unit: [rad].
};

/// Length of a motion: |(translation, gyration rotation)|. Unit: [m].
/// \param gyration how far a turn by one radian moves the body, as a whole. Unit: [m].
double length_of(const Motion& motion, double gyration);

/// The result of constrained_motion().
struct ConstrainedMotion {
  Motion motion;
  bool held = false;  ///< some plane holds the body back
};

/// The motion nearest to `wanted`, by length_of(), with
///
///     gap_k + n_k . (translation + rotation x (foot_k - handle)) >= 0      for all planes k:
///
/// Gauss' principle of least constraint as in Ortega, Redon and Coquillart (2007), solved for its multipliers
/// by projected Gauss-Seidel sweeps; exact for a single plane. Planes that contradict each other get the
/// least violation.
ConstrainedMotion constrained_motion(const Motion& wanted, std::span<const SurfacePatch> planes,
                                     const Eigen::Vector3d& handle, double gyration);

}  // namespace palpate
