/// \file
/// Path of a hand through a room from touch to touch of a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/study/touch_path.h>

namespace palpate {

/// Motion and workspace of the hand. World frame, z up.
struct RoomPathOptions {
  std::size_t touches = 7;        ///< >= 1
  std::uint64_t seed = 1;         ///< of the choice of places
  Pose home;                      ///< where it begins and waits, and how the tool is turned throughout
  Eigen::AlignedBox3d reach;      ///< of the tool's centre. Unit: [m].
  double press = 0.03;            ///< beyond first contact. Unit: [m]. >= 0
  double slide = 0.05;            ///< at that depth. Unit: [m]. >= 0
  double wait = 1.5, hold = 1.5;  ///< at home, and where it is pressed. Unit: [s].
  double rate = 1000.0;           ///< poses a second. Unit: [Hz].
};

/// One touch of a path.
struct RoomTouch {
  PressPlace place;  ///< `touch` at first contact of the tool as it is turned
  /// Of the path: when it begins to come near, is pressed all the way, begins to slide, and is away again.
  /// Unit: [s].
  double begins = 0.0, pressed = 0.0, slides = 0.0, ends = 0.0;
};

struct RoomPath {
  Trajectory path;
  std::vector<RoomTouch> touches;
};

/// From home over the scene to place after place: down or in along a straight line, pressed, held, slid, and
/// back up. Moves with the least jerk, at 0.5 m/s at most, and 0.1 m/s near the surface. Places are those of
/// touch_places() that can be reached with nothing in the way, as far apart as they come, ordered around the
/// scene.
///
/// \throws Error as touch_places(), and where fewer places than asked for can be reached.
RoomPath room_path(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                   const RoomPathOptions& options);

}  // namespace palpate
