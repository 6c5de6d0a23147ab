/// \file
/// Scripted exploration path of a scene, for use without a recorded hand motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/haptics/tool.h>
#include <palpate/record/trajectory.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// Options of a path. Margins are not options: they follow from the tool's smallest semi-axis, so that paths
/// suit scenes of any size.
struct TouchPathOptions {
  int touches = 7;         ///< places to touch, 1 to 1000
  std::uint64_t seed = 1;  ///< of the choice of places
  double press = 0.005;    ///< below first contact, along the approach, not negative. Unit: [m].
  double slide = 0.05;     ///< along the surface at that depth, not negative. Unit: [m].
  double rate = 1000.0;    ///< poses per second, positive, at most 1e5. Unit: [Hz].
  /// \name Limits of speed and acceleration, as of a hand. Positive.
  /// @{
  double speed = 0.5;         ///< Unit: [m/s].
  double acceleration = 5.0;  ///< Unit: [m/s^2].
  /// @}
};

/// Number of contacting Gaussians at which a surface begins, so that a stray floater does not count.
inline constexpr std::size_t kSolidContacts = 3;

/// A place at which a surface is pressed and slid along.
struct PressPlace {
  Pose touch;              ///< of the tool at first contact, world frame
  Eigen::Vector3d inward;  ///< unit vector, direction of approach
  Eigen::Vector3d along;   ///< unit vector orthogonal to `inward`, direction of the slide
};

/// A path that touches up to `options.touches` places of the scene one after the other. At each, the tool
/// approaches from free space along a straight line, presses in, slides at the same depth below first contact
/// (a shorter distance where the surface ends or a wall begins), lifts off, and retreats; between places it
/// travels on a sphere around the central 98 % of the centres. The tool's z axis points along the approach
/// while it is near a place and turns while it travels. Poses are 1 / rate apart from t = 0; the speed is
/// continuous and zero at the corners of the path.
///
/// Places are drawn at random from the scene and kept if a solid surface faces the approach without an
/// obstacle; of these, the ones that differ most in position and colour are chosen, and ordered for a short
/// path. A scene with fewer such places gets fewer touches. The travel is free of contact if a sphere up to
/// 1.5 times as large allows it. The same arguments give the same path.
///
/// \param query over the Gaussians of `scene`.
/// \throws Error if an option or the tool is out of range, the scene is empty, no place is found, or the
/// scene is so large that a hand takes too long around it; the last two name a scale that suits the tool.
Trajectory touch_path(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                      const TouchPathOptions& options);

/// Returns the places that touch_path() touches, in order. \throws Error as touch_path(), except for a large
/// scene.
std::vector<PressPlace> touch_places(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                                     const TouchPathOptions& options);

}  // namespace palpate
