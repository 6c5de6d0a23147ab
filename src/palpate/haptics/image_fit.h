/// \file
/// What a patch of surface is made from: the far side of the tool in a view, and a quadric through the depth
/// image that is seen there. World frame; lengths in m unless they say otherwise.
#pragma once

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/haptics/depth_view.h>

namespace palpate {

/// Where a view sees `point`.
Eigen::Vector2d image_of(const ViewFrame& view, const Eigen::Vector3d& point);

/// From one place towards another, by `most` at most.
Eigen::Vector2d towards(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double most);

/// Profile::depth() and Profile::below() in double.
double depth_of(const Profile& profile, const Eigen::Vector2d& place);
bool is_below(const Profile& profile, const Eigen::Vector2d& place);

/// Where a ray at `place` begins: a quarter of its way through the solid, so that what is behind the solid is
/// not taken for what is in front of it.
double start_of(const Profile& profile, const Eigen::Vector2d& place);

/// Where the first of all rays through the solid begins, looking along the unit vector `along`.
double start_of_all(const Profile& profile, const Ellipsoid& solid, const Eigen::Vector3d& along);

/// The unit normal of the solid at a point of its surface, into it.
Eigen::Vector3d inward_normal(const Ellipsoid& solid, const Eigen::Vector3d& point);

/// How the far side of the solid runs at a place below it: slope and curvature of its depth.
struct ToolSide {
  /// \pre is_below(profile, place)
  ToolSide(const Profile& profile, const Eigen::Vector2d& place);

  /// How much of `bend`, of a surface's depth, is above the least curvature of the tool, by its principal
  /// directions. Unit: [1/m].
  Eigen::Matrix2d more_than_tool(const Eigen::Matrix2d& bend) const;

  /// The way to where a surface of that slope here, whose depth bends by `bend`, runs as the tool does: where
  /// there is the least between them.
  Eigen::Vector2d to_least(const Eigen::Vector2d& surface, const Eigen::Matrix2d& bend) const;

  Eigen::Vector2d slope;
  Eigen::Matrix2d curvature;  ///< of minus the depth: positive definite. Unit: [1/m].
};

/// A quadric through what is seen around a place: robust least squares with little priors that it is flat.
class ImageFit {
 public:
  struct Window {
    Eigen::Vector2d center;  ///< in the image
    double detail;           ///< the unit of the fit. > 0
    double level;            ///< depth that heights are counted from
    float radius;            ///< in details
  };

  /// Fits to what was seen in the last look of `image`. False if hardly anything is: the fit is then not to
  /// be used.
  bool to(const DepthView& image, const Window& window);

  double depth(const Eigen::Vector2d& place) const;
  /// Root mean square of the distance of what is seen from the fit.
  double roughness() const;
  /// Of the depth at the centre of the window.
  Eigen::Vector2d slope() const { return {of_[1], of_[2]}; }
  Eigen::Matrix2d bend() const;  ///< the depth's second derivatives. Unit: [1/m].
  const DepthMoments& moments() const { return moments_; }

 private:
  using Terms = Eigen::Matrix<double, DepthMoments::kTerms, 1>;
  static Terms solve(const DepthMoments& moments);

  Window window_{};
  Terms of_ = Terms::Zero();  ///< height, slopes, mean curvature and its difference; in details
  DepthMoments moments_;
};

}  // namespace palpate
