/// \file
/// The felt surface near a tool: what many small, noisy ellipsoids are together.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <palpate/collision/contact.h>
#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// A place where the tool touches or may soon touch: the plane that the surface has there. World frame.
struct SurfacePatch {
  Eigen::Vector3d normal;  ///< unit, towards the tool
  Eigen::Vector3d foot;    ///< the tool's own point that is first to touch: its support point along -normal
  double gap = 0.0;        ///< from the surface to `foot`, along the normal; negative inside. Unit: [m].
  double support = 0.0;    ///< sum of the weights of its contacts: about how many there are
};

/// How the surface is made of contacts.
///
/// The contacts are those of a tool that is larger by `reach` on all sides, so that the surface is seen
/// before it is touched and beside where it is. Around the foot of the tool, in its tangent plane with
/// coordinates u,
///
///     minimise  sum_i w_i (z_i - a - b . u_i - c |u_i|^2)^2
///     w_i = alpha_i S(K_i) (1 - |u_i|^2 / (10 detail^2))^3 S(n_i . n)
///
/// over height a, slope b and mean curvature c, with z_i the height of contact i's point and S a smooth step.
/// It is moving least squares (Levin 1998; Alexa et al. 2003) with the curvature that keeps round things from
/// shrinking. With splats `spacing` apart and displaced by `noise`, the slope is off by noise spacing /
/// (sqrt(8 pi) detail^2) a axis; a mean over splats, not a sum, so that density does not matter. S(K_i) lets
/// contacts come and go smoothly; S(n_i . n) keeps the patches of a corner apart.
struct SurfaceKernel {
  double detail;  ///< of the surface, that survives: the standard deviation of the kernel. Unit: [m]. > 0
  double reach;   ///< how much larger the tool is on all sides when contacts are looked for. Unit: [m]. > 0

  /// One whose reach shows the kernel out to two of its deviations under a ball of radius `a_min`, the tool's
  /// thinnest semi-axis: (a_min + reach)^2 = a_min^2 + (2 detail)^2.
  static SurfaceKernel for_tool(double a_min, double detail);
};

/// The patches that a tool touches, kept from one instant to the next. Takes nothing from the heap.
class SurfacePatches {
 public:
  /// As many constraints as a rigid body has degrees of freedom, and two to choose from.
  static constexpr std::size_t kMost = 8;

  explicit SurfacePatches(const SurfaceKernel& kernel) : kernel_(kernel) {}

  void clear() { size_ = 0; }

  /// Fits the patches anew to `contacts`, those of `tool` enlarged by SurfaceKernel::reach: first the ones
  /// that were there, from where they were, then any that the contacts show besides.
  void update(std::span<const Contact> contacts, const Ellipsoid& tool);

  std::span<const SurfacePatch> patches() const { return {patches_.data(), size_}; }

 private:
  /// Moves `patch` to where the contacts near it are; false if there are none.
  bool fit(std::span<const Contact> contacts, const Ellipsoid& tool, int rounds, SurfacePatch& patch) const;
  void keep_if_new(const SurfacePatch& patch);

  SurfaceKernel kernel_;
  std::size_t size_ = 0;
  std::array<SurfacePatch, kMost> patches_;
};

}  // namespace palpate
