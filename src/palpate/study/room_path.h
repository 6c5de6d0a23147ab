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
  Pose home;                      ///< initial and waiting pose; the tool keeps its orientation
  Eigen::AlignedBox3d reach;      ///< reachable positions of the tool's centre. Unit: [m].
  double press = 0.03;            ///< depth beyond first contact. Unit: [m]. >= 0
  double slide = 0.05;            ///< distance at that depth. Unit: [m]. >= 0
  double wait = 1.5, hold = 1.5;  ///< at home, and where it is pressed. Unit: [s].
  double rate = 1000.0;           ///< poses per second. Unit: [Hz].
};

/// One touch of a path.
struct RoomTouch {
  PressPlace place;  ///< `touch` at first contact of the tool in the orientation of `home`
  /// Times at which the approach begins, the tool is fully pressed, the slide begins, and the tool is away
  /// again. Unit: [s].
  double begins = 0.0, pressed = 0.0, slides = 0.0, ends = 0.0;
};

struct RoomPath {
  Trajectory path;
  std::vector<RoomTouch> touches;
};

/// Path from home over the scene to place after place: approach along a straight line, press, hold, slide,
/// and back up. Minimum-jerk motions at up to 0.5 m/s, and 0.1 m/s near the surface. Places are those of
/// touch_places() that can be reached without an obstacle, as far apart as possible, ordered around the
/// scene.
///
/// \throws Error as touch_places(), and if fewer places than requested can be reached.
RoomPath room_path(const ContactQuery& query, const EllipsoidScene& scene, const Tool& tool,
                   const RoomPathOptions& options);

}  // namespace palpate
