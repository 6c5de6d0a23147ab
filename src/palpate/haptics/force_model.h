/// \file
/// Interface of force models.
#pragma once

#include <limits>

#include <palpate/collision/contact.h>
#include <palpate/geometry/pose.h>
#include <palpate/haptics/local_surface.h>

namespace palpate {

/// Input of a force model at one instant. Every number is finite.
struct ForceInput {
  Pose tool;        ///< X_WT
  Twist velocity;   ///< V_WT: of the tool, unfiltered
  double dt = 0.0;  ///< time since the last call; 0 if there was none. Unit: [s].
  /// Contacts of all parts of the tool at this pose; null if the model does not want them.
  const ContactSet* contacts = nullptr;
  /// Peak force of the device: more is clamped, which a model may do better itself. Unit: [N]. > 0
  double force_max = std::numeric_limits<double>::infinity();
  /// Largest damping that the device can render: a model must not exceed it. Unit: [N s/m].
  double damping_max = std::numeric_limits<double>::infinity();
  /// Fraction of the force that the device renders: 0 while the start gate is shut. In [0, 1].
  double force_scale = 1.0;
};

/// Output of a force model.
struct ForceOutput {
  Wrench wrench;  ///< F_T_W: on the tool, torque about its handle, expressed in the world
  /// X_WP: pose of the proxy, which does not enter any object; the tool's pose if the model has no proxy.
  Pose proxy;
  /// Confidence that a surface exists at the proxy, in [0, 1]; see SurfacePatch. 1 without contact and for
  /// models without confidence.
  double confidence = 1.0;
  /// Stored energy: in the spring that generates the wrench and any other storage, recoverable as work. NaN
  /// if the model has no potential. Unit: [J].
  double stored_energy = 0.0;
  /// Stiffness of that spring in the current contact along any direction, and about any axis through the
  /// handle; 0 without contact. Unit: [N/m], [N m/rad].
  double stiffness = 0.0, angular_stiffness = 0.0;
  /// Whether both are of one spring at a lever: a motion along and about at once is then up to twice as
  /// stiff.
  bool at_lever = false;
  LocalSurface local = {};  ///< surface around the tool, world frame
  /// False while the model does not know yet what the tool is in: the wrench is then zero and says nothing.
  bool is_known = true;
};

/// Turns contacts into a wrench on the tool. A model may keep state between calls (filters), so an
/// object serves one tool on one thread. evaluate() does not throw, allocate, lock or do I/O.
class ForceModel {
 public:
  virtual ~ForceModel() = default;

  /// Returns false if the model searches for contacts itself.
  virtual bool wants_contacts() const { return true; }

  /// Resets the state to that before the first call.
  virtual void reset() = 0;

  /// Computes the wrench at this instant. Called once per tick, in order of time.
  virtual ForceOutput evaluate(const ForceInput& input) = 0;
};

}  // namespace palpate
