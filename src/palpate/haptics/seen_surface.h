/// \file
/// Where a captured surface is seen: the reference that what is felt is held against.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <palpate/geometry/similarity.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// A scene as splatting draws it, all of its Gaussians, in double precision and without an index. Along a ray
/// they are composited front to back, each where the ray is nearest to it by its own measure, with
///
///     alpha = opacity exp(-m^2 / 2), at most 0.99        (Kerbl et al. 2023)
///
/// and the seen surface is where the transmittance falls below one half. Shares no code with the force
/// models. Immutable; any number of threads may ask at once.
class SeenSurface {
 public:
  SeenSurface(const GaussianScene& scene, const Similarity& world_from_scene);

  /// How far along the unit vector `along` a ray from `from` sees the surface; nothing if it does not. World
  /// frame. Unit: [m].
  std::optional<double> depth(const Eigen::Vector3d& from, const Eigen::Vector3d& along) const;

  /// How far a tool of the orientation of the world goes from `from` along the unit vector `along` until the
  /// first of the rays of its cross-section meets the seen surface: kRings rings of rays for each part, those
  /// in the middle and a part in fifty from the silhouette included. Unit: [m].
  std::optional<double> first_touch(const Tool& tool, const Eigen::Vector3d& from,
                                    const Eigen::Vector3d& along) const;

  static constexpr int kRings = 8;

 private:
  struct Splat {
    Eigen::Vector3d center;
    Eigen::Matrix3d whitening;  ///< m^2 = |whitening (x - center)|^2
    double radius;              ///< beyond which it is not drawn
    double opacity;
  };
  using Splats = std::vector<const Splat*>;

  /// Those that rays along `along`, within `radius` of the one from `from`, may meet.
  Splats near(const Eigen::Vector3d& from, const Eigen::Vector3d& along, double radius) const;
  static std::optional<double> composite(const Splats& splats, const Eigen::Vector3d& from,
                                         const Eigen::Vector3d& along);

  std::vector<Splat> splats_;
};

}  // namespace palpate
