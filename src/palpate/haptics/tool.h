/// \file
/// Tool geometry: a rigid body of ellipsoids.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// One ellipsoid of a tool.
struct ToolPart {
  std::string name;           ///< for people
  Eigen::Vector3d semi_axes;  ///< Unit: [m]. Positive.
  Pose pose = {};             ///< X_TP: of its centre and axes in the tool frame T

  /// Solid of the part in the world for the tool at X_WT.
  Ellipsoid at(const Pose& X_WT) const { return Ellipsoid::from_semi_axes(X_WT * pose, semi_axes); }

  bool operator==(const ToolPart&) const = default;
};

/// A rigid body of one or more ellipsoids, which may overlap. The origin of its frame is the handle: the
/// point whose pose a device reports, and about which torque is taken.
class Tool {
 public:
  /// The default tool, 20 x 20 x 40 mm.
  Tool() : Tool(Eigen::Vector3d(0.02, 0.02, 0.04)) {}
  /// One ellipsoid, centred on the handle with its axes along the frame's. \pre positive and finite
  explicit Tool(const Eigen::Vector3d& semi_axes);
  /// \pre not empty; semi-axes positive, all of it finite
  explicit Tool(std::vector<ToolPart> parts);

  std::span<const ToolPart> parts() const { return parts_; }

  bool operator==(const Tool&) const = default;

  /// The shortest semi-axis of all parts. Unit: [m].
  double thinnest() const;
  /// The longest semi-axis of all parts. Unit: [m].
  double longest() const;
  /// Radius of the sphere around the handle that contains all parts. Unit: [m].
  double radius() const;
  /// Mean radius of gyration about the handle of the parts as solids of equal density: mean displacement of
  /// the tool by a rotation of one radian. Unit: [m].
  double gyration() const;
  /// Support of a tool at the origin: the farthest extent of its points along the unit vector `n`. Unit: [m].
  double support(const Eigen::Vector3d& n) const;

 private:
  std::vector<ToolPart> parts_;
};

}  // namespace palpate
