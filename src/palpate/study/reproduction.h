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
  /// The true surface, in the captured frame; null if unknown.
  const AnalyticSurface* surface = nullptr;
  Similarity world_from_scene;
};

/// Device type.
enum class ReproductionDevice : std::uint8_t {
  kAdmittance,  ///< GiantDevice behind AdmittanceLoop
  /// Renders a wrench without delay, with the mass and damping of the admittance device's handle in free
  /// space.
  kImpedance,
};
std::string_view to_string(ReproductionDevice device);

/// Force model under test.
struct ReproductionModel {
  std::string name;
  std::unique_ptr<ForceModel> force;
  /// Contact query for a model that takes contacts, in every tick. Null: the model finds its own, and its
  /// contacts are counted separately.
  const ContactQuery* contacts = nullptr;
  double stall = 0.0;  ///< time that a force takes to compute, and is then held. Unit: [s].
};

/// One tick.
struct ReproductionTick {
  double t = 0.0;        ///< Unit: [s].
  Eigen::Vector3d tool;  ///< centre of the tool, world frame. Unit: [m].
  std::size_t candidates = 0, filtered = 0, colliding = 0;
  Eigen::Vector3d felt = Eigen::Vector3d::Zero();   ///< force of the model on the tool. Unit: [N].
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< force sent to the device. Unit: [N].
  Eigen::Vector3d user = Eigen::Vector3d::Zero();   ///< measured force of the hand. Unit: [N].
  /// Processor time of the thread and wall-clock time, for contacts and force. Unit: [us].
  double cpu_us = 0.0, wall_us = 0.0;
  /// Depth of a ball tool in the true surface, and the normal there; NaN and 0 if unknown. Unit: [m].
  double depth = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// Result of one touch.
struct ReproductionContact {
  double begins = 0.0;             ///< first tick with force. Unit: [s]. NaN: there was none
  std::size_t colliding = 0;       ///< largest number
  double force = 0.0, user = 0.0;  ///< means of the last half second of the hold. Unit: [N].
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of that force, unit
  /// Peak to peak of the tool along the way in, during that half second, about a linear fit: sliding down a
  /// slope is no swing. Unit: [m].
  double swing = 0.0;
  double overshoot = 0.0;  ///< largest depth minus the mean during that half second. Unit: [m].
  int bounces = 0;         ///< number of times that the force ended before that half second, on a rebound
  double depth = 0.0;      ///< true depth, mean of that half second. Unit: [m].
  double off = 0.0;        ///< angle of `direction` from the true normal. Unit: [rad].
};

struct ReproductionRun {
  std::string model;
  ReproductionDevice device = ReproductionDevice::kAdmittance;
  double stall = 0.0;  ///< Unit: [s].
  std::vector<ReproductionTick> ticks;
  std::vector<ReproductionContact> contacts;  ///< one per touch
  double port_energy = 0.0;                   ///< PassivityController::port_energy(). Unit: [J].
  std::vector<std::string> faults;            ///< names, once each
  std::size_t held_ticks = 0;                 ///< ticks in which a limit of the device held its motion
};

/// Creates the mechanics of the room-scale device, with a hand on the given path.
using JointPlantMaker = std::function<std::unique_ptr<JointPlant>(const GiantSetup&, HandPath)>;

/// Simulates a hand that moves the tool along `path` with `device`. \param setup its contact_stiffness is one
/// for which the admittance is stable \param plant for kAdmittance
ReproductionRun reproduce(const ReproductionScene& scene, const Tool& tool, const RoomPath& path,
                          ReproductionModel model, ReproductionDevice device, const GiantSetup& setup,
                          const JointPlantMaker& plant, const Progress& progress = {});

}  // namespace palpate
