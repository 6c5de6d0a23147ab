/// \file
/// Filter from a captured scene to solid ellipsoids: which Gaussians are kept (paper III-A), the size of
/// their ellipsoids, and registration into the world (paper eq. 3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/base/progress.h>
#include <palpate/geometry/ellipsoid.h>
#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Selection of solid Gaussians, and the size of their ellipsoids.
struct SceneFilter {
  /// Kept if alpha > opacity_min (the paper's threshold, 0.1 to 0.3). In [0, 1].
  double opacity_min = 0.1;
  /// Size of a Gaussian's ellipsoid in standard deviations. Positive.
  double sigma = 1.0;
  /// Limits of `sigma`. Splatting draws nothing beyond 3.4; larger ellipsoids only cost time.
  static constexpr double kSigmaMin = 1e-6, kSigmaMax = 10.0;
  /// If set, replaces sigma by the level set at which splatting draws alpha = iso: k_i = sqrt(2 ln(alpha_i /
  /// iso)). Gaussians with alpha <= iso are dropped. In (0, 1).
  std::optional<double> iso;
  /// Kept if the longest standard deviation in the world is at most this. Unit: [m].
  std::optional<double> max_scale;
  /// Kept if the centre is inside. World frame. Unit: [m].
  std::optional<Eigen::AlignedBox3d> crop_box;
  struct Sphere {
    Eigen::Vector3d center;
    double radius;

    bool operator==(const Sphere&) const = default;
  };
  std::optional<Sphere> crop_sphere;  ///< kept if the centre is inside, as crop_box

  bool operator==(const SceneFilter& other) const;
};

/// Checks the ranges of a filter and of a registration. \throws Error that names the first member out of its
/// range.
void check_filter(const SceneFilter& filter, const Similarity& world_from_scene);

/// Number of Gaussians kept and dropped, for a scene or a part of one; each is counted once, at the first
/// rule that drops it in the order of the members.
struct FilterReport {
  std::size_t total = 0;
  std::array<std::size_t, kDefectCount> defects{};  ///< by Defect; [kNone] stays 0
  std::size_t low_opacity = 0;
  std::size_t below_iso = 0;
  std::size_t over_max_scale = 0;
  std::size_t outside_crop = 0;
  std::size_t kept = 0;

  /// Total number of Gaussians dropped because of a defect.
  std::size_t defective() const;

  bool operator==(const FilterReport&) const = default;
};

/// Adds the report of another part of the same scene.
FilterReport& operator+=(FilterReport& sum, const FilterReport& part);

/// The ellipsoids of the kept Gaussians in the world frame, in increasing order of id.
struct EllipsoidScene {
  std::vector<Ellipsoid> ellipsoids;               ///< Unit: [m].
  std::vector<double> opacity;                     ///< alpha
  std::vector<std::uint32_t> id;                   ///< row in the file
  std::vector<std::array<std::uint8_t, 3>> color;  ///< sRGB; empty if the file has none

  std::size_t size() const { return ellipsoids.size(); }
};

/// Box of the central 98 % of the centres in each coordinate. \pre not empty. Unit: [m].
Eigen::AlignedBox3d central_box(const EllipsoidScene& scene);

/// k of the ellipsoid of a Gaussian: the standard deviations out to which it is solid.
/// \pre with iso set, opacity > *iso.
double sigma_multiple(double opacity, const SceneFilter& filter);

/// The ellipsoid of `gaussian` under `filter`, registered by `world_from_scene`: centre
/// c = s R_g mu + t, semi-axes k s R_g R diag(sigma), k = sigma_multiple(). Never forms a covariance.
/// \pre with iso set, gaussian.opacity > *iso.
Ellipsoid world_ellipsoid(const Gaussian& gaussian, const SceneFilter& filter,
                          const Similarity& world_from_scene);

/// True if `filter` keeps Gaussian i of `scene`, registered by `world_from_scene`. `activated` is
/// scene.gaussian(i). Counts it in `report`: in the total, and as kept or dropped. Several threads may
/// process parts of a scene, each with its own report.
bool keeps(const GaussianScene& scene, std::size_t i, const Gaussian& activated, const SceneFilter& filter,
           const Similarity& world_from_scene, FilterReport& report);

/// Applies filter and registration. `report` receives the counts. Runs in parallel on the caller's oneTBB
/// arena; the result does not depend on the number of threads.
EllipsoidScene filter_scene(const GaussianScene& scene, const SceneFilter& filter,
                            const Similarity& world_from_scene, FilterReport& report,
                            const Progress& progress = {});

}  // namespace palpate
