/// \file
/// Placement of a scene in the room of a large device.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>
#include <palpate/scene/up_axis.h>
#include <palpate/study/procedural.h>

namespace palpate {

/// Registration and filter of a scene in the room.
struct RoomPlacement {
  UpAxis frame = UpAxis::kAsIs;
  Similarity registration;
  SceneFilter filter;
};

/// A procedural scene as large as fits, a captured one as large as suits the tool: beside where the handle
/// rests, or the middle of it below. What is too low for the handle is not touched. \param tool_radius the
/// thinnest. Unit: [m]. \param home of the handle, world frame \throws Error if `filter` leaves nothing
RoomPlacement place_in_room(const GaussianScene& scene, const SceneFilter& filter, double tool_radius,
                            const Eigen::Vector3d& home);

/// A million Gaussians on the surface of a truck, with what captures have wrong with them.
GaussianScene procedural_truck(const AnalyticSurface& surface, std::uint64_t seed);

}  // namespace palpate
