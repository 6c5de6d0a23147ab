/// \file
/// Visible surface of a captured scene, the reference for the evaluation of forces.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <palpate/geometry/similarity.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// A scene as rendered by splatting: all of its Gaussians, in double precision and without an index. Along a
/// ray they are composited front to back, each where the ray is nearest to it by its own measure, with
///
///     alpha = opacity exp(-m^2 / 2), at most 0.99        (Kerbl et al. 2023)
///
/// and the seen surface is where the transmittance falls below one half. Shares no code with the force
/// models. Immutable; any number of threads may query it concurrently.
class SeenSurface {
 public:
  SeenSurface(const GaussianScene& scene, const Similarity& world_from_scene);

  static constexpr double kHalf = 0.5;  ///< transmittance below which the surface is seen

  /// Distance along the unit vector `along` at which a ray from `from` meets the surface; nothing if it does
  /// not. World frame. Unit: [m]. \param left transmittance below which it does
  std::optional<double> depth(const Eigen::Vector3d& from, const Eigen::Vector3d& along,
                              double left = kHalf) const;

  /// As SeenRays::first_touch(), for a single path.
  std::optional<double> first_touch(const Tool& tool, const Eigen::Vector3d& from,
                                    const Eigen::Vector3d& along) const;

 private:
  friend class SeenRays;
  struct Splat {
    Eigen::Vector3d center;
    Eigen::Matrix3d whitening;  ///< m^2 = |whitening (x - center)|^2
    double radius;              ///< distance from the centre beyond which it is not drawn
    double opacity;
  };

  std::vector<Splat> splats_;
};

/// The parallel rays near one line. World frame; lengths in m. Immutable.
class SeenRays {
 public:
  /// Rays along the unit vector `along`, at most `radius` from the one through `from`; they begin in the
  /// plane through `from` perpendicular to them.
  SeenRays(const SeenSurface& scene, const Eigen::Vector3d& from, const Eigen::Vector3d& along,
           double radius);

  /// Number of rings of rays of a cross-section: one ray in the middle, and six more in each ring than in the
  /// one before.
  static constexpr int kRings = 8;

  /// Distance from the plane at which the ray through `point` meets the surface; nothing if it does not.
  std::optional<double> depth(const Eigen::Vector3d& point, double left = SeenSurface::kHalf) const;

  /// Distance that a tool in the orientation of the world moves from `from`, displaced across the rays by
  /// `aside`, until the first ray of its cross-section meets the seen surface. Each part has a ray in the
  /// middle and `rings` rings, the outermost 2 % inside the silhouette.
  std::optional<double> first_touch(const Tool& tool, const Eigen::Vector3d& aside = Eigen::Vector3d::Zero(),
                                    int rings = kRings) const;

 private:
  /// Projection of a splat: at (x, y) from its middle, across the rays, m^2 = aa x^2 + 2 ab x y + bb y^2, at
  /// the depth t + x tx + y ty.
  struct Image {
    Eigen::Vector2d middle;
    double aa, ab, bb;
    double t, tx, ty;
    double radius, opacity;
  };

  Eigen::Vector3d from_, along_, u_, v_;
  std::vector<Image> images_;
};

}  // namespace palpate
