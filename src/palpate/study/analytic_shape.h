/// \file
/// Elementary surfaces whose distance, normal and area are known exactly.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/study/random.h>

namespace palpate {

/// The point of a surface that is nearest to a query point p. Same frame as p.
struct NearestPoint {
  Eigen::Vector3d point;  ///< Unit: [m].
  /// Outward unit normal at `point`. At an edge or a corner of a solid, where there is none, the
  /// direction from `point` to p, which is always among the outward directions there.
  Eigen::Vector3d normal;
  double distance;  ///< From p. Negative inside a closed surface, never negative for a sheet. Unit: [m].
};

/// One point of a sampling.
struct SurfaceSample {
  Eigen::Vector3d point;    ///< Unit: [m].
  Eigen::Vector3d normal;   ///< outward, unit
  Eigen::Vector3d tangent;  ///< unit, orthogonal to `normal`; normal x tangent completes the frame
  /// Distance to its neighbours: the requested spacing, or less on a face narrower than that. Unit: [m].
  double spacing;
};

/// A surface in a frame of its own: either the boundary of a solid (closed) or an open sheet of no
/// thickness, whose outward side is only a convention.
class AnalyticShape {
 public:
  virtual ~AnalyticShape() = default;

  virtual bool closed() const = 0;

  /// Unit: [m^2].
  virtual double area() const = 0;

  /// Exact up to rounding. If several points are nearest, one of them.
  virtual NearestPoint nearest(const Eigen::Vector3d& p) const = 0;

  /// Appends about area() / spacing^2 points of equal density. The surface is divided into cells of
  /// equal area that are about square, with one point at random in the middle of each, so that no
  /// point of the surface is farther than about 1.1 spacing from a sample. Faces narrower than
  /// `spacing` are sampled at their width. \pre spacing is positive and finite. Unit: [m].
  virtual void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const = 0;
};

// Lengths in [m], all positive. Every shape but the dome and the torus is centred on the origin in
// the obvious way: a box along the axes, a cylinder with its axis along z.

/// Closed.
std::unique_ptr<AnalyticShape> make_sphere(double radius);
/// Closed, with sharp edges.
std::unique_ptr<AnalyticShape> make_box(const Eigen::Vector3d& size);
/// Closed by flat caps.
std::unique_ptr<AnalyticShape> make_cylinder(double radius, double height);
/// Closed, about the z axis: a tube of radius `minor` around the circle of radius `major` > `minor`.
std::unique_ptr<AnalyticShape> make_torus(double major, double minor);
/// A sheet in z = 0 with its outward side towards +z.
std::unique_ptr<AnalyticShape> make_rectangle(double size_x, double size_y);
/// A sheet: the half z >= 0 of the sphere about the origin, outward away from the origin.
std::unique_ptr<AnalyticShape> make_dome(double radius);

}  // namespace palpate
