/// \file
/// What is recorded of one tick.
#pragma once

#include <cstddef>
#include <optional>

#include <palpate/geometry/pose.h>

namespace palpate {

/// One tick.
struct RunRow {
  double t = 0.0;              ///< Unit: [s].
  Pose tool;                   ///< world frame
  std::size_t candidates = 0;  ///< after the broad phase
  std::size_t filtered = 0;    ///< after the bounding spheres, paper eq. 4
  std::size_t colliding = 0;   ///< after the overlap test
  double k_max = 0.0;          ///< largest K_min; 0 without contact
  Wrench wrench;               ///< on the tool
  Eigen::Vector3d proxy =
      Eigen::Vector3d::Zero();  ///< the tool centre where the model has no proxy. Unit: [m].
  double compute_us = 0.0;      ///< time for the force and the contacts that it is made of. Unit: [us].
  std::optional<Eigen::Vector3d> user_force;  ///< measured at the handle, world frame. Unit: [N].
};

}  // namespace palpate
