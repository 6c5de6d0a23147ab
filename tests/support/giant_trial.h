/// \file
/// A hand that presses with a room-scale device against what a force model feels, in virtual time.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <palpate/device/giant_device.h>
#include <palpate/device/giant_plant.h>
#include <palpate/kinematics/chain_file.h>
#include <palpate/servo/admittance_loop.h>
#include <palpate/servo/servo_tick.h>
#include <support/tick.h>

namespace palpate::test {

/// Five people, from a soft hand to a stiff one.
inline constexpr std::array<HandProperties, 5> kOperators{
    {{0.05, 2.0, 100.0}, {0.1, 3.0, 200.0}, {0.15, 4.0, 400.0}, {0.2, 6.0, 700.0}, {0.3, 10.0, 1000.0}}};

/// The built-in chain, once a program.
inline const SerialChain& giant() {
  static const SerialChain chain = giant_chain();
  return chain;
}

/// Where the TCP is while the joints rest.
inline Pose giant_home() { return JointMotion(giant()).tip(); }

using PlantMaker =
    std::function<std::unique_ptr<JointPlant>(const JointPlantProperties&, const GripProperties&, HandPath)>;

inline std::unique_ptr<JointPlant> own_plant(const JointPlantProperties& drives, const GripProperties& grip,
                                             HandPath path) {
  return std::make_unique<GiantPlant>(giant(), drives, grip, std::move(path));
}

/// What is tried. The hand waits at giant_home(), goes `depth` beyond the place where the model is felt
/// first, in half a second, and stays.
struct GiantTrial {
  HandProperties hand = kOperators[2];
  FeltModel felt;
  WorkspaceMap map;
  Eigen::Vector3d inward = -Eigen::Vector3d::UnitX();  ///< device's frame
  double depth = 0.05;                                 ///< Unit: [m].
  GiantProperties properties;
  Admittance admittance;
  AdmittanceLoopModel along;  ///< contact and hand; the rest is the device's
  double margin = 0.0;        ///< see AdmittanceLoopOptions
  bool keeps_passive = true;
  PlantMaker plant = own_plant;
};

struct GiantOutcome {
  double limit_cycle = 0.0,
         wander = 0.0;  ///< extent of the way in the last second, along `inward` and in all. Unit: [m].
  double deepest = 0.0, rest = 0.0;  ///< of the TCP, along `inward`. Unit: [m].
  double scene_force = 0.0,
         user_force = 0.0;   ///< means of the last second, along -inward and inward. Unit: [N].
  double true_force = 0.0;   ///< of the hand, as the plant has it. Unit: [N].
  double port_energy = 0.0;  ///< PassivityController::port_energy(). Unit: [J].
  double early = 0.0,
         late = 0.0;  ///< extents along `inward` in 2.5 to 3 s, and in the last half second. Unit: [m].
  Fault fault = Fault::kNone, motion_fault = Fault::kNone;
  double overshoot() const { return deepest - rest; }
};

inline constexpr double kGiantWaits = 1.5, kGiantEnds = 5.5;  ///< Unit: [s].

inline HandPath press_path(const Eigen::Vector3d& inward, double depth) {
  const Pose home = giant_home();
  return [=](double t) {
    const double u = std::clamp((t - kGiantWaits) / 0.5, 0.0, 1.0);
    Pose pose = home;
    pose.position += depth * u * u * (3.0 - 2.0 * u) * inward;
    return pose;
  };
}

inline AdmittanceLoopModel trial_loop(const GiantTrial& trial) {
  AdmittanceLoopModel loop = loop_model(giant(), trial.properties);
  loop.contact_stiffness = trial.along.contact_stiffness;
  loop.contact_damping = trial.along.contact_damping;
  loop.hand_mass = trial.hand.mass;
  loop.hand_damping = trial.hand.damping;
  loop.hand_stiffness = trial.hand.stiffness;
  return loop;
}

inline AdmittanceLoopOptions trial_options(const GiantTrial& trial) {
  AdmittanceLoopOptions options;
  options.admittance = trial.admittance;
  options.along = trial_loop(trial);
  options.about = loop_model(giant(), trial.properties);
  options.margin = trial.margin;
  return options;
}

/// \throws Error where the admittance is refused
inline GiantOutcome run_trial(const GiantTrial& trial) {
  const GripProperties grip{trial.hand, 0.05};
  const HandPath path = press_path(trial.inward, trial.depth);
  GiantDevice device(giant(), trial.plant(trial.properties.drives, grip, path), trial.properties,
                     giant_home());
  AdmittanceLoop loop(device, trial_options(trial));
  ServoTickOptions options;
  options.map = trial.map;
  options.keeps_passive = trial.keeps_passive;
  ServoTick tick(loop, trial.felt, options);
  GiantOutcome outcome;
  Eigen::AlignedBox3d rest;
  double low = 1e9, high = -1e9;
  Eigen::AlignedBox<double, 1> early, late;
  int resting = 0;
  const Eigen::Vector3d home = giant_home().position;
  for (int k = 0; k * kTick < kGiantEnds; ++k) {
    const TickRecord& now = tick.run(k * kTick);
    const Eigen::Vector3d at = device.pose().position;
    const double depth = (at - home).dot(trial.inward);
    outcome.deepest = std::max(outcome.deepest, depth);
    outcome.port_energy = now.port_energy;
    if (outcome.fault == Fault::kNone) outcome.fault = now.fault;
    if (outcome.motion_fault == Fault::kNone) outcome.motion_fault = loop.governor().fault();
    if (k * kTick > kGiantWaits + 1.0 && k * kTick < kGiantWaits + 1.5)
      early.extend(Eigen::Matrix<double, 1, 1>(depth));
    if (k * kTick > kGiantEnds - 0.5) late.extend(Eigen::Matrix<double, 1, 1>(depth));
    if (k * kTick < kGiantEnds - 1.0) continue;
    rest.extend(at);
    low = std::min(low, depth);
    high = std::max(high, depth);
    outcome.rest += depth;
    outcome.scene_force -= now.sent.force.dot(trial.inward);
    outcome.user_force += loop.user().force.dot(trial.inward);
    outcome.true_force += device.hand().force.dot(trial.inward);
    ++resting;
  }
  for (double* mean : {&outcome.rest, &outcome.scene_force, &outcome.user_force, &outcome.true_force})
    *mean /= resting;
  outcome.limit_cycle = high - low;
  outcome.early = early.diagonal()[0];
  outcome.late = late.diagonal()[0];
  outcome.wander = rest.diagonal().norm();
  return outcome;
}

}  // namespace palpate::test
