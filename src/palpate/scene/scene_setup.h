/// \file
/// Automatic proposal of frame, scale, filter and crop for an unknown scene.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>

#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/up_axis.h>

namespace palpate {

/// A proposed value and its reason, a sentence without a full stop.
template <typename T>
struct Proposal {
  T value;
  std::string reason;
};

/// Proposed settings for touching a scene. The user may override them: each proposal gives its reason.
struct SceneSetup {
  /// Captured axis that points up, as --frame names it: the normal of the plane to which most surface area is
  /// parallel, oriented so that most of the scene is above that plane. kAsIs if no direction is dominant, or
  /// neither side of the plane has more of the scene, as in one that is the same upside down.
  Proposal<UpAxis> frame;
  /// Metres per captured unit at which the typical Gaussian is kGaussiansAcross times smaller than the tool,
  /// so that surfaces feel smooth.
  Proposal<double> scale;
  /// The highest of kPaperThresholds that keeps at least kSeenShare of the visible amount: opacity times
  /// area.
  Proposal<double> opacity_min;
  /// Longest standard deviation of a Gaussian that is neither an outlier nor giant (LintReport), after
  /// `scale`; nothing if none is longer. Unit: [m].
  Proposal<std::optional<double>> max_scale;
  /// Box around the scene without its outliers, after `frame` and `scale`; nothing if there are no outliers.
  /// World frame. Unit: [m].
  Proposal<std::optional<Eigen::AlignedBox3d>> crop_box;

  static constexpr double kGaussiansAcross = 7.0, kSeenShare = 0.95;
};

/// \param tool_radius shortest semi-axis of the tool. Unit: [m]. > 0
/// \throws Error if no Gaussian of `scene` can collide.
SceneSetup propose_setup(const GaussianScene& scene, double tool_radius);

}  // namespace palpate
