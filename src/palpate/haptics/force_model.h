/// \file
/// From contacts to what the hand feels.
#pragma once

#include <limits>

#include <palpate/collision/contact.h>
#include <palpate/geometry/pose.h>
#include <palpate/haptics/local_surface.h>

namespace palpate {

/// What a force model is told at one instant. Every number is finite.
struct ForceInput {
  Pose tool;        ///< X_WT
  Twist velocity;   ///< V_WT: of the tool, unfiltered
  double dt = 0.0;  ///< time since the last call; 0 if there was none. Unit: [s].
  /// Of all parts of the tool at this pose; null if the model does not want them.
  const ContactSet* contacts = nullptr;
  /// What the device can show: more will be cut off, which a model may do better itself. Unit: [N]. > 0
  double force_max = std::numeric_limits<double>::infinity();
  /// The damping that it can show: a model has no more. Unit: [N s/m].
  double damping_max = std::numeric_limits<double>::infinity();
};

/// What a force model answers.
struct ForceOutput {
  Wrench wrench;  ///< F_T_W: on the tool, torque about its handle, expressed in the world
  /// X_WP: where the tool would be if it could not enter anything; the tool's pose where the model has none.
  Pose proxy;
  /// How far there is a surface where the tool is held, in [0, 1]; see SurfacePatch. 1 where nothing holds it
  /// and where the model has none.
  double confidence = 1.0;
  /// In the spring that makes the wrench, and wherever else energy is kept: what may come back as work. NaN
  /// where the model has no potential. Unit: [J].
  double stored_energy = 0.0;
  /// Of that spring, as it is felt now; 0 where nothing is. Unit: [N/m].
  double stiffness = 0.0;
  LocalSurface local = {};  ///< about the tool, world frame
};

/// Turns contacts into a wrench on the tool. A model may keep state between calls (filters), so an
/// object serves one tool on one thread. evaluate() does not throw, allocate, lock or do I/O.
class ForceModel {
 public:
  virtual ~ForceModel() = default;

  /// False if the model looks for contacts by itself.
  virtual bool wants_contacts() const { return true; }

  /// Forgets all state, as if no call had been made.
  virtual void reset() = 0;

  /// What is felt at this instant. Called once a tick, in order of time.
  virtual ForceOutput evaluate(const ForceInput& input) = 0;
};

}  // namespace palpate
