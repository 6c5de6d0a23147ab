/// \file
/// Proposal of frame, scale, filter and crop for a scene of which nothing but its Gaussians is known.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>

#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/up_axis.h>

namespace palpate {

/// A proposed value, and the reason for it, as a sentence without an end.
template <typename T>
struct Proposal {
  T value;
  std::string reason;
};

/// How a scene might be felt. A person may know better: each proposal gives its reason.
struct SceneSetup {
  /// Captured axis that points up, as --frame names it: normal of the plane that the most surface is parallel
  /// to, with most of the scene above that plane. kAsIs where no direction stands out, or neither side of the
  /// plane has more of the scene, as in one that is the same upside down.
  Proposal<UpAxis> frame;
  /// Metres per captured unit with which the usual Gaussian is kGaussiansAcross times smaller than the tool,
  /// so that a surface is smooth to it.
  Proposal<double> scale;
  /// The highest of kPaperThresholds that keeps kSeenShare of what is seen: opacity times area.
  Proposal<double> opacity_min;
  /// Longest standard deviation of a Gaussian that is neither an outlier nor giant (LintReport), after
  /// `scale`; nothing if none is longer. Unit: [m].
  Proposal<std::optional<double>> max_scale;
  /// Box around the scene without its outliers, after `frame` and `scale`; nothing if there are none. World
  /// frame. Unit: [m].
  Proposal<std::optional<Eigen::AlignedBox3d>> crop_box;

  static constexpr double kGaussiansAcross = 7.0, kSeenShare = 0.95;
};

/// \param tool_radius shortest semi-axis of the tool. Unit: [m]. > 0
/// \throws Error if no Gaussian of `scene` can collide.
SceneSetup propose_setup(const GaussianScene& scene, double tool_radius);

}  // namespace palpate
