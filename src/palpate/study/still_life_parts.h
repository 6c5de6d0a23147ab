/// \file
/// Objects of the still-life scene: surfaces, paint and occupied space.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <palpate/geometry/pose.h>
#include <palpate/haptics/material.h>
#include <palpate/study/analytic_shape.h>
#include <palpate/study/painted_patch.h>

namespace palpate::still_life {

/// One object, before it is sampled as Gaussians.
struct Thing {
  std::string name;
  Material material;
  std::vector<PaintedPatch> patches;
  std::vector<Occluder> room;  ///< what it takes of space; `object` is set by who puts the things together
  std::shared_ptr<const AnalyticShape> shape = {};
  Pose pose = {};
  double relief = 0.0;
};

/// Half of the table. Unit: [m].
inline constexpr double kTableHalfX = 0.44, kTableHalfY = 0.31;

/// Where the bowl stands, and the cloth under it, in the plane of the table. Unit: [m].
const Eigen::Vector3d& bowl_place();

/// The room that is taken so far, in which round things come to rest: the least height of the centre of a
/// ball of `radius` at (x, y) that comes down from above. Unit: [m].
double rest_height(const SoftLight& taken, double x, double y, double radius);

Thing make_table(double spacing);
Thing make_cloth(double spacing);
Thing make_bowl(double spacing);
Thing make_log(double spacing);
Thing make_plate(double spacing);
/// \param tilt of its largest face against the table. Unit: [rad].
Thing make_stone(double spacing, const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes, double turn,
                 double tilt, unsigned rgb, std::uint32_t seed);
/// \name Fruit about `center`, with its stalk towards `up`
/// @{
Thing make_orange(double spacing, const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& up,
                  std::uint32_t seed);
Thing make_apple(double spacing, const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& up,
                 unsigned rgb, unsigned blush, std::uint32_t seed);
Thing make_pear(double spacing, const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& up,
                std::uint32_t seed);
Thing make_lemon(double spacing, const Eigen::Vector3d& center, double radius, const Eigen::Vector3d& up,
                 std::uint32_t seed);
Thing make_grape(double spacing, const Eigen::Vector3d& center, double radius, std::uint32_t seed);
/// @}

}  // namespace palpate::still_life
