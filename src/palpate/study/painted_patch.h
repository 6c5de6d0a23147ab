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
  /// A point of the world; with dP/du x dP/dv outward.
  std::function<Eigen::Vector3d(double u, double v)> at;
  /// May depend on the parameters and the place.
  std::function<Paint(double u, double v, const Eigen::Vector3d& place)> paint;
  double spacing;  ///< of neighbours. Unit: [m].
  /// Of which nothing is made where it is false; everything if empty.
  std::function<bool(const Eigen::Vector3d&)> keeps = {};
};

/// sRGB as one writes it (0xff8800), to linear.
Eigen::Vector3d linear_color(unsigned rgb);

/// Appends rows of flat Gaussians as far apart as `spacing` says, wherever nothing of another object than
/// `object` covers the surface by more than half a millimetre. What varies at random comes from `random`
/// alone.
void append_patch(const PaintedPatch& patch, const SoftLight& light, int object, Random& random,
                  GaussianScene& scene);

}  // namespace palpate
