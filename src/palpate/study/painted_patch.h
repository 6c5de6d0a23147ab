/// \file
/// Parametric surface patches sampled as Gaussians with baked light.
#pragma once

#include <functional>

#include <Eigen/Core>

#include <palpate/scene/gaussian_scene.h>
#include <palpate/study/random.h>
#include <palpate/study/soft_light.h>

namespace palpate {

/// Material colour of a surface at a place.
struct Paint {
  Eigen::Vector3d albedo;  ///< linear, in [0, 1]
  double gloss = 0.0;      ///< in [0, 1]
};

/// A piece of a surface: the image of the unit square.
struct PaintedPatch {
  /// Point in the world frame; dP/du x dP/dv points outward.
  std::function<Eigen::Vector3d(double u, double v)> at;
  /// Paint at the parameters and the point.
  std::function<Paint(double u, double v, const Eigen::Vector3d& place)> paint;
  double spacing;  ///< of neighbours. Unit: [m].
  /// Points for which it returns false get no Gaussians; unset: all get them.
  std::function<bool(const Eigen::Vector3d&)> keeps = {};
};

/// Converts sRGB, such as 0xff8800, to linear.
Eigen::Vector3d linear_color(unsigned rgb);

/// Appends rows of flat Gaussians at the patch's spacing, except where an object other than `object` covers
/// the surface by more than half a millimetre. `random` is the only source of randomness.
void append_patch(const PaintedPatch& patch, const SoftLight& light, int object, Random& random,
                  GaussianScene& scene);

}  // namespace palpate
