/// \file
/// Objects of the still-life scene: surfaces, paint and occupied space.
#pragma once

#include <algorithm>
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
  std::vector<Occluder> room;  ///< space that it occupies; `object` is set by the caller
  std::shared_ptr<const AnalyticShape> shape = {};
  Pose pose = {};
  double relief = 0.0;
};

/// Rises from 0 at `low` to 1 at `high`, with zero slope at both ends.
inline double smooth(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}
inline Eigen::Vector3d mixed(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + share * (b - a);
}

/// Half sizes of the table. Unit: [m].
inline constexpr double kTableHalfX = 0.44, kTableHalfY = 0.31;

/// Position of the bowl, on top of the cloth. Unit: [m].
const Eigen::Vector3d& bowl_place();

/// Height at which the centre of a ball of `radius` comes to rest when it is lowered at (x, y) onto the
/// occupied space `taken`. Unit: [m].
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
