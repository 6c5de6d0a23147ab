/// \file
/// The rigid motion nearest to a wanted one that does not enter any of a few planes.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace palpate {

/// A small motion of a rigid body: of its handle, and about it. World frame.
struct Motion {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< Unit: [m].
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector. Unit: [rad].
};

/// Length of a motion: |(translation, gyration rotation)|. Unit: [m].
/// \param gyration how far a turn by one radian moves the body, as a whole. Unit: [m].
double length_of(const Motion& motion, double gyration);

/// A plane in front of a point of the body.
struct MotionConstraint {
  Eigen::Vector3d normal;  ///< unit, away from the plane. World frame.
  Eigen::Vector3d arm;     ///< from the handle to the point, world frame. Unit: [m].
  double gap;              ///< from the plane to the point along the normal; negative inside. Unit: [m].
  double friction = 0.0;   ///< Coulomb's coefficient
  // What the plane takes from the motion, set by constrained_motion():
  double push = 0.0;                               ///< along the normal. Unit: [m].
  Eigen::Vector3d drag = Eigen::Vector3d::Zero();  ///< along the plane. Unit: [m].
  double clear_until = 0.0;  ///< way of all points, in the solver, before which it takes nothing. Unit: [m].

  /// How a motion moves the point. Unit: [m].
  Eigen::Vector3d of(const Motion& motion) const { return motion.translation + motion.rotation.cross(arm); }
};

/// The motion nearest to `wanted`, by length_of(), with, for all planes k,
///
///     gap_k + n_k . v_k >= 0,    v_k = translation + rotation x arm_k
///
/// and pushes that are not negative: Gauss' principle of least constraint as in Ortega, Redon and Coquillart
/// (2007). With friction also v_k = 0 along the plane, as far as drag_k <= friction_k push_k can hold the
/// point: Coulomb's law. Solved for pushes and drags by projected Gauss-Seidel sweeps; exact for a single
/// plane without friction. Planes that contradict each other get the least violation.
Motion constrained_motion(const Motion& wanted, std::span<MotionConstraint> planes, double gyration);

}  // namespace palpate
