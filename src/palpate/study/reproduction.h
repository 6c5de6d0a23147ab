/// \file
/// Reproduction of the paper's evaluation (section V) on a simulated room-scale device, in virtual time.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/collision/scene_index.h>
#include <palpate/device/giant_setup.h>
#include <palpate/haptics/force_model.h>
#include <palpate/study/procedural.h>
#include <palpate/study/room_path.h>

namespace palpate {

/// A scene registered to the room of the device. World frame: that of the device's base.
struct ReproductionScene {
  const SceneIndex* index = nullptr;
  const EllipsoidScene* kept = nullptr;
  const ContactQuery* paper = nullptr;  ///< PaperPipeline over `kept`
  /// The true surface, where it is known: of the captured frame.
  const AnalyticSurface* surface = nullptr;
  Similarity world_from_scene;
};

/// Device type.
enum class ReproductionDevice : std::uint8_t {
  kAdmittance,  ///< GiantDevice behind AdmittanceLoop
  /// One that takes a wrench and shows it without delay, as heavy and as damped as the handle of the other in
  /// free space.
  kImpedance,
};
std::string_view to_string(ReproductionDevice device);

/// Force model under test.
struct ReproductionModel {
  std::string name;
  std::unique_ptr<ForceModel> force;
  /// Where the model wants contacts: what finds them, in every tick. Null: it asks by itself, and what it
  /// touches is looked up besides.
  const ContactQuery* contacts = nullptr;
  double stall = 0.0;  ///< for how long a force takes to compute, and is then held. Unit: [s].
};

/// One tick.
struct ReproductionTick {
  double t = 0.0;        ///< Unit: [s].
  Eigen::Vector3d tool;  ///< its centre, world frame. Unit: [m].
  std::size_t candidates = 0, filtered = 0, colliding = 0;
  Eigen::Vector3d felt = Eigen::Vector3d::Zero();   ///< on the tool, by the model. Unit: [N].
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< of that, what the device was sent. Unit: [N].
  Eigen::Vector3d user = Eigen::Vector3d::Zero();   ///< of the hand, as measured. Unit: [N].
  /// For the force and the contacts that it is made of: what the thread spent, and what went by. Unit: [us].
  double cpu_us = 0.0, wall_us = 0.0;
  /// How deep a ball tool is in the true surface, and which way that faces; NaN where it is not known. Unit:
  /// [m].
  double depth = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// Result of one touch.
struct ReproductionContact {
  double begins = 0.0;             ///< first tick with force. Unit: [s]. NaN: there was none
  std::size_t colliding = 0;       ///< the most
  double force = 0.0, user = 0.0;  ///< means of the last half second of the hold. Unit: [N].
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of that force, unit
  /// Peak to peak of the tool along the way in, then, about the straight line that it goes: what slides down
  /// a slope does not swing. Unit: [m].
  double swing = 0.0;
  double overshoot = 0.0;  ///< of the deepest over the mean of then. Unit: [m].
  int bounces = 0;         ///< how often the force ended before then on the way back out
  double depth = 0.0;      ///< true, mean of then. Unit: [m].
  double off = 0.0;        ///< of `direction` from the true normal. Unit: [rad].
};

struct ReproductionRun {
  std::string model;
  ReproductionDevice device = ReproductionDevice::kAdmittance;
  double stall = 0.0;  ///< Unit: [s].
  std::vector<ReproductionTick> ticks;
  std::vector<ReproductionContact> contacts;  ///< one a touch
  double port_energy = 0.0;                   ///< PassivityController::put_out(). Unit: [J].
  std::vector<std::string> faults;            ///< names, once each
  std::size_t held_ticks = 0;                 ///< in which a limit of the device held its motion
};

/// Makes the mechanics of the giant with a hand on that path.
using JointPlantMaker = std::function<std::unique_ptr<JointPlant>(const GiantSetup&, HandPath)>;

/// Simulates a hand that moves the tool along `path` with that device. \param setup its contact_stiffness is
/// what the admittance is stable with \param plant of kAdmittance
ReproductionRun reproduce(const ReproductionScene& scene, const Tool& tool, const RoomPath& path,
                          ReproductionModel model, ReproductionDevice device, const GiantSetup& setup,
                          const JointPlantMaker& plant, const Progress& progress = {});

}  // namespace palpate
