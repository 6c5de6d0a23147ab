/// \file
/// The felt surface near a solid: what many small, noisy ellipsoids are together.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/haptics/surface_contacts.h>

namespace palpate {

/// A place where the tool touches or may soon touch: the plane that the surface has there. World frame.
struct SurfacePatch {
  Eigen::Vector3d normal;  ///< unit, towards the tool
  Eigen::Vector3d foot;    ///< the tool's own point that is first to touch: its support point along -normal
  double gap = 0.0;        ///< from the surface to `foot`, along the normal; negative inside. Unit: [m].
  /// How far there is a surface at all, in [0, 1]: 1 where Gaussians cover what the tool touches and hide
  /// what is behind them, less in holes, at what floats alone, and where light comes through.
  double confidence = 1.0;
};

/// SurfacePatch::confidence: S(layers / 0.25) min(1, alpha / 0.9), with S a smooth step, `layers` the number
/// of Gaussians that lie over each other and alpha = 1 - (1 - mean opacity)^max(1, layers), which is what
/// they hide together. It is the alpha of paper eq. 9, as it is seen.
double confidence_of(const SurfaceMoments& moments);

/// The patches that one solid of a tool touches, kept from one instant to the next. Takes nothing from the
/// heap.
///
/// The contacts are those of a solid that is larger by SurfaceKernel::reach on all sides, so that the surface
/// is seen before it is touched and beside where it is. Around the foot, in its tangent plane with
/// coordinates u,
///
///     minimise  sum_i w_i (z_i - a - b . u_i - c |u_i|^2)^2
///     w_i = alpha_i S(K_i) / (1 + (h_i / thickness)^4) (1 - |u_i|^2 / (10 detail^2))^3 S(n_i . n)
///
/// over height a, slope b and mean curvature c, with z_i the height of contact i's point, h_i half the
/// thickness of its Gaussian along its normal, and S a smooth step. It is moving least squares (Levin 1998;
/// Alexa et al. 2003) with the curvature that keeps round things from shrinking. With splats `spacing` apart
/// and displaced by `noise`, the slope is off by noise spacing / (sqrt(8 pi) detail^2) a axis; a mean over
/// splats, not a sum, so that density does not matter. S(K_i) lets contacts come and go smoothly; S(n_i . n)
/// keeps the patches of a corner apart; what is thick is a blur and tells little about where the surface is.
class SurfacePatches {
 public:
  /// As many constraints as a rigid body has degrees of freedom, and two to choose from.
  static constexpr std::size_t kMost = 8;

  explicit SurfacePatches(const SurfaceKernel& kernel) : kernel_(kernel) {}

  const SurfaceKernel& kernel() const { return kernel_; }
  void clear() { size_ = 0; }

  /// Fits the patches of `solid` anew to `contacts`: first the ones that were there, from where they were,
  /// then any that the contacts show besides.
  void update(SurfaceContacts& contacts, const Ellipsoid& solid);

  std::span<const SurfacePatch> patches() const { return {patches_.data(), size_}; }

 private:
  /// Moves `patch` to where the contacts near it are; false if there are none.
  bool fit(SurfaceContacts& contacts, const Ellipsoid& solid, int rounds, SurfacePatch& patch) const;
  bool keep_if_new(const SurfacePatch& patch);

  SurfaceKernel kernel_;
  std::size_t size_ = 0;
  std::array<SurfacePatch, kMost> patches_;
};

}  // namespace palpate
