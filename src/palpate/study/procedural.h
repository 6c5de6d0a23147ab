/// \file
/// Procedural scenes with an exactly known surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/geometry/pose.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/study/analytic_shape.h>

namespace palpate {

/// One piece of a surface, in one colour.
struct SurfacePart {
  std::string name;                            ///< e.g. "bowl"
  std::array<std::uint8_t, 3> color;           ///< sRGB
  Pose pose;                                   ///< from the frame of `shape` to the world
  std::shared_ptr<const AnalyticShape> shape;  ///< not null
};

/// A sample of a surface in the world, and the part it is from.
struct PartSample {
  SurfaceSample sample;
  std::size_t part;  ///< index into AnalyticSurface::parts()
};

/// A union of parts in the world frame. The parts may touch, but must not penetrate each other. Immutable;
/// any number of threads may query it concurrently.
class AnalyticSurface {
 public:
  /// \param default_spacing of samplings that request none. Unit: [m].
  AnalyticSurface(std::string name, double default_spacing, std::vector<SurfacePart> parts);

  const std::string& name() const { return name_; }
  double default_spacing() const { return default_spacing_; }
  std::span<const SurfacePart> parts() const { return parts_; }

  /// True if every part is the boundary of a solid, so that distances have a sign everywhere.
  bool closed() const;

  /// Sum over the parts, covered faces (see samples()) included. Unit: [m^2].
  double area() const;

  /// Distance of p to the nearest part: exact up to rounding outside every solid, negative inside
  /// one, and never negative near a sheet. Inside a solid it is the depth below that solid's own
  /// boundary, also where the boundary is covered by another part. Unit: [m].
  double distance(const Eigen::Vector3d& p) const { return project(p).distance; }

  /// The nearest point of all parts.
  NearestPoint project(const Eigen::Vector3d& p) const;

  /// Points of all parts at the mean distance `spacing`, see AnalyticShape::sample(). Points that
  /// another part covers are left out: the underside of a box that stands on a table cannot be
  /// touched, nor captured. \pre spacing is positive and finite. Unit: [m].
  std::vector<PartSample> samples(double spacing, Random& random) const;

 private:
  std::string name_;
  double default_spacing_;
  std::vector<SurfacePart> parts_;
};

/// Options of sampling a surface as Gaussians.
struct ProceduralOptions {
  std::uint64_t seed = 1;
  /// Mean distance of neighbours: a surface of area A gets about A / spacing^2 Gaussians. Positive;
  /// the surface's own default if unset. Unit: [m].
  std::optional<double> spacing = {};
  /// Standard deviation of the displacement along the true normal, not negative. Unit: [m].
  double noise = 0.0;
  /// Standard deviation of the angle between the splat's normal and the true one, about a random
  /// axis in the surface, not negative. Unit: [rad].
  double tilt = 0.0;
};

/// Maximum number of Gaussians of a procedural scene: about 1.5 GB.
inline constexpr std::size_t kMaxProceduralGaussians = 20'000'000;

/// Returns the names that make_surface() accepts. Lengths in m, z up, centred on the origin:
///   sphere    R 0.15
///   plane     0.4 x 0.4 sheet in z = 0, outward +z
///   box       0.3 x 0.2 x 0.16 solid with sharp edges
///   cylinder  R 0.1, height 0.3 along z, closed by caps
///   torus     R 0.12, r 0.05 about z
///   step      0.4 x 0.4 sheet, z = 0 for x < 0 and z = 0.003 for x > 0, with the face between
///   shell     the upper half of a sphere of R 0.15, a sheet: both sides can be touched
///   table     a top of 0.8 x 0.6 with its upper face in z = 0, on four legs, and on it a ball, a
///             crate, a can, a ring, a bowl (a sheet, open upwards) and a stack of two books
///   truck     a pick-up truck of 5.3 m on its wheels, front towards +x, with lamps, and a barrel, a ball and
///             a spare wheel in its bed
std::span<const std::string_view> procedural_shapes();

/// \throws Error if `name` is not among procedural_shapes().
std::unique_ptr<AnalyticSurface> make_surface(std::string_view name);

/// One flat Gaussian for each sample: round but for a random variation, of random opacity and
/// random orientation in its plane, its local z axis along the (tilted) normal, ids 0, 1, ... The
/// same options give the same scene on every run; on another platform it may differ in the last
/// bit of a coordinate, where the mathematical library does.
/// \throws Error if an option is out of its range or asks for more than kMaxProceduralGaussians.
GaussianScene make_scene(const AnalyticSurface& surface, const ProceduralOptions& options);

}  // namespace palpate
