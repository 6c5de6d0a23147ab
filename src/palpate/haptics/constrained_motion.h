/// \file
/// Constrained rigid motion: nearest to a given motion without entering any of a few planes.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace palpate {

/// A small motion of a rigid body: translation of its handle and rotation about it. World frame.
struct Motion {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< Unit: [m].
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector. Unit: [rad].
};

/// Length of a motion: |(translation, gyration rotation)|. Unit: [m]. \param gyration mean displacement of
/// the body by a rotation of one radian. Unit: [m].
double length_of(const Motion& motion, double gyration);

/// Constraint that keeps a point of the body in front of a plane.
struct MotionConstraint {
  Eigen::Vector3d normal;  ///< unit, away from the plane. World frame.
  Eigen::Vector3d arm;     ///< from the handle to the point, world frame. Unit: [m].
  double gap;              ///< from the plane to the point along the normal; negative inside. Unit: [m].
  double friction = 0.0;   ///< Coulomb's coefficient
  // Components of the motion removed by the plane, set by constrained_motion():
  double push = 0.0;                               ///< along the normal. Unit: [m].
  Eigen::Vector3d drag = Eigen::Vector3d::Zero();  ///< along the plane. Unit: [m].
  double clear_until =
      0.0;  ///< in the solver: travel of all points below which the plane is inactive. Unit: [m].

  /// Displacement of the point by a motion. Unit: [m].
  Eigen::Vector3d of(const Motion& motion) const { return motion.translation + motion.rotation.cross(arm); }
};

/// Number of planes up to which constrained_motion() makes as many sweeps as it needs.
constexpr std::size_t kMostPlanesSolved = 64;

/// Returns the motion nearest to `wanted`, by length_of(), with, for all planes k,
///
///     gap_k + n_k . v_k >= 0,    v_k = translation + rotation x arm_k
///
/// and non-negative pushes: Gauss' principle of least constraint as in Ortega, Redon and Coquillart (2007).
/// With friction also v_k = 0 along the plane, as far as drag_k <= friction_k push_k can hold the point:
/// Coulomb's law. Solved for pushes and drags by projected Gauss-Seidel sweeps; exact for a single plane
/// without friction. Contradictory planes are violated as little as possible.
Motion constrained_motion(const Motion& wanted, std::span<MotionConstraint> planes, double gyration);

}  // namespace palpate
