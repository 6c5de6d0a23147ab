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

/// Places a procedural scene as large as fits, or a captured one as large as suits the tool, beside the rest
/// position of the handle or, if it is too large for that, with its middle below it. Parts too low for the
/// handle are not touched. \param tool_radius shortest semi-axis. Unit: [m]. \param home rest position of the
/// handle, world frame \throws Error if `filter` keeps nothing
RoomPlacement place_in_room(const GaussianScene& scene, const SceneFilter& filter, double tool_radius,
                            const Eigen::Vector3d& home);

/// A million Gaussians on the surface of a truck, with typical defects of captures.
GaussianScene procedural_truck(const AnalyticSurface& surface, std::uint64_t seed);

}  // namespace palpate
