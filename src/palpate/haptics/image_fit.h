/// \file
/// Surface fit of a patch: the far side of the tool in a view, and a quadric fitted to the depth image. World
/// frame; lengths in m unless they say otherwise.
#pragma once

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/haptics/depth_view.h>

namespace palpate {

/// Returns the image coordinates of `point` in a view.
Eigen::Vector2d image_of(const ViewFrame& view, const Eigen::Vector3d& point);

/// Moves from one place towards another, by `most` at most.
Eigen::Vector2d towards(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double most);

/// Profile::depth() and Profile::below() in double.
double depth_of(const Profile& profile, const Eigen::Vector2d& place);
bool is_below(const Profile& profile, const Eigen::Vector2d& place);

/// Returns the depth where a ray at `place` begins: a quarter of its way through the solid, so that surfaces
/// behind the solid are not taken for surfaces in front of it.
double start_of(const Profile& profile, const Eigen::Vector2d& place);

/// Returns the least depth at which any ray through the solid begins, looking along the unit vector `along`.
double start_of_all(const Profile& profile, const Ellipsoid& solid, const Eigen::Vector3d& along);

/// Returns the inward unit normal of the solid at a point of its surface.
Eigen::Vector3d inward_normal(const Ellipsoid& solid, const Eigen::Vector3d& point);

/// Slope and curvature of the depth of the solid's far side at a place below it.
struct ToolSide {
  /// \pre is_below(profile, place)
  ToolSide(const Profile& profile, const Eigen::Vector2d& place);

  /// Returns the part of `bend`, the second derivatives of a surface's depth, above the least curvature of
  /// the tool, by its principal directions. Unit: [1/m].
  Eigen::Matrix2d more_than_tool(const Eigen::Matrix2d& bend) const;

  /// Returns the displacement to the place of least clearance, where a surface of that slope here and of
  /// second derivatives `bend` is parallel to the tool.
  Eigen::Vector2d to_least(const Eigen::Vector2d& surface, const Eigen::Matrix2d& bend) const;

  Eigen::Vector2d slope;
  Eigen::Matrix2d curvature;  ///< of minus the depth: positive definite. Unit: [1/m].
};

/// Quadric fit to the depth image around a place: robust least squares with weak priors of flatness.
class ImageFit {
 public:
  struct Window {
    Eigen::Vector2d center;  ///< in the image
    double detail;           ///< the unit of the fit. > 0
    double level;            ///< depth that heights are counted from
    float radius;            ///< in details
  };

  /// Fits to the last view of `image`. \returns false if there are hardly any hits: the fit must then not be
  /// used.
  bool to(const DepthView& image, const Window& window);

  double depth(const Eigen::Vector2d& place) const;
  /// Root mean square distance of the hits from the fit.
  double roughness() const;
  /// Slope of the depth at the centre of the window.
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
