/// \file
/// From contacts to what the hand feels.
#pragma once

#include <palpate/collision/contact.h>
#include <palpate/geometry/pose.h>

namespace palpate {

/// What a force model is told at one instant. Every number is finite.
struct ForceInput {
  Pose tool;                             ///< world frame
  Twist velocity;                        ///< of the tool, unfiltered, world frame
  double dt = 0.0;                       ///< time since the last call; 0 if there was none. Unit: [s].
  const ContactSet* contacts = nullptr;  ///< of this pose; not null
};

/// What a force model answers.
struct ForceOutput {
  Wrench wrench;  ///< on the tool
  Pose
      proxy;  ///< where the tool would be if it could not enter anything; the tool's where the model has none
};

/// Turns contacts into a wrench on the tool. A model may keep state between calls (filters), so an
/// object serves one tool on one thread. evaluate() does not throw, allocate, lock or do I/O.
class ForceModel {
 public:
  virtual ~ForceModel() = default;

  /// Forgets all state, as if no call had been made.
  virtual void reset() = 0;

  /// What is felt at this instant. Called once a tick, in order of time.
  virtual ForceOutput evaluate(const ForceInput& input) = 0;
};

}  // namespace palpate
