/// \file
/// Run row: the record of one tick.
#pragma once

#include <cstddef>
#include <optional>

#include <palpate/geometry/pose.h>
#include <palpate/servo/fault.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {

struct TickRecord;
struct TickTimes;

/// Additional columns of a live loop; a replay has no device.
struct LiveColumns {
  Twist velocity;  ///< V_WT: of the tool
  /// Wrench sent to the motors, after safety, F_H_W: torque about the handle, along the axes of the world;
  /// RunRow::wrench is the output of the force model.
  Wrench sent;
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
  double energy = 0.0;         ///< SafetyGovernor::energy(): net, put into the hand. Unit: [J].
  double stored_energy = 0.0;  ///< ForceOutput::stored_energy; 0 for a model without a potential. Unit: [J].
  double damping = 0.0;        ///< added by the passivity controller. Unit: [N s/m].
  double margin = 0.0;  ///< factor by which the stiffness may grow before the spring is active; 0 if unknown
  double age_us = 0.0;  ///< from the device reading to sending its force. Unit: [us].
};

/// One tick.
struct RunRow {
  double t = 0.0;              ///< Unit: [s].
  Pose tool;                   ///< X_WT
  std::size_t candidates = 0;  ///< after the broad phase
  std::size_t filtered = 0;    ///< after the bounding spheres, paper eq. 4
  std::size_t colliding = 0;   ///< after the overlap test
  double k_max = 0.0;          ///< largest K_min; 0 without contact
  Wrench wrench;               ///< F_T_W: on the tool, torque about its handle
  Eigen::Vector3d proxy =
      Eigen::Vector3d::Zero();                ///< the tool centre where the model has no proxy. Unit: [m].
  double compute_us = 0.0;                    ///< time to compute contacts and force. Unit: [us].
  std::optional<Eigen::Vector3d> user_force;  ///< measured at the handle, world frame. Unit: [N].
  std::optional<LiveColumns> live;
};

/// The row of a live tick. No heap allocation; servo thread.
RunRow run_row(const TickRecord& record, const TickTimes& times);

}  // namespace palpate
