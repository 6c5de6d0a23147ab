/// \file
/// Contact places and push directions of the trials. Internal to study/.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <palpate/haptics/tool.h>
#include <palpate/study/procedural.h>
#include <palpate/study/random.h>

namespace palpate {

/// A straight path of a tool. World frame.
struct TrialAim {
  Eigen::Vector3d point;   ///< target of the handle. Unit: [m].
  Eigen::Vector3d along;   ///< unit
  Eigen::Vector3d normal;  ///< outward, unit; at an edge or corner, its bisector
  Tool tool;               ///< in the orientation in which it is held
};

/// A known solid or sheet, sized for a tool, and a kind of place on it. Immutable.
class TrialPlace {
 public:
  /// \param name of trial_places() \param variant 0 or 1: the thickness of a plate is one or two of the
  /// tool's thinnest semi-axes; a hole is wider than the tool or narrower.
  TrialPlace(const std::string& name, const Tool& tool, std::size_t variant);

  const AnalyticSurface& surface() const { return *surface_; }
  /// Mean distance of neighbouring Gaussians, as suits the tool. Unit: [m].
  double spacing() const { return spacing_; }

  bool starts_inside() const { return name_ == "inside"; }
  /// True if the surface is flat under the tool.
  bool is_flat() const { return name_ != "edge" && name_ != "corner" && name_ != "hole"; }
  /// Thickness of a plate; 0 for a sheet; nothing if a tool cannot come out on the other side. Unit: [m].
  std::optional<double> thickness() const { return thickness_; }

  /// Height of the plane that flat places are in. World frame. Unit: [m].
  double top() const { return half_[2]; }

  /// Draws an aim. \param tip_first the tool's z axis points ahead; otherwise its orientation is random
  TrialAim aim(Random& random, bool tip_first) const;

 private:
  void make_box();
  void make_slab(double thickness);
  void make_hole(bool wider);
  void own(std::unique_ptr<AnalyticShape> shape);
  Eigen::Vector3d point_at(Random& random, Eigen::Vector3d& normal) const;

  std::string name_;
  Tool tool_;
  double spacing_;
  std::unique_ptr<AnalyticSurface> surface_;
  Eigen::Vector3d half_ = Eigen::Vector3d::Zero();  ///< half sizes of a box or sheet. Unit: [m].
  double major_ = 0.0, minor_ = 0.0;                ///< radii of a ring. Unit: [m].
  std::optional<double> thickness_;
};

/// Depth of the deepest of many points of the tool's ellipsoids; negative outside, never positive at a sheet.
/// Unit: [m].
double deepest(const AnalyticSurface& surface, const Tool& tool, const Pose& pose);

/// Depth of the deep pushes of trials below first contact; more for tools thicker than 40 mm. Unit: [m].
inline constexpr double kDeepestTrial = 0.06;

}  // namespace palpate
