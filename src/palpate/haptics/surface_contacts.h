/// \file
/// Contacts as the fit of a surface wants them, and its sums over them.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <palpate/collision/contact.h>
#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// How the surface is made of contacts; see SurfacePatches.
struct SurfaceKernel {
  double detail;  ///< of the surface, that survives: the standard deviation of the kernel. Unit: [m]. > 0
  double reach;   ///< how much larger the tool is on all sides when contacts are looked for. Unit: [m]. > 0
  /// A Gaussian of half this thickness along the normal is half as good a witness of where the surface is.
  /// Unit: [m]. > 0
  double thickness;

  /// One whose reach shows the kernel out to two of its deviations under a ball of radius `a_min`, the
  /// solid's thinnest semi-axis: (a_min + reach)^2 = a_min^2 + (2 detail)^2. \param extent Contact::extent of
  /// a usual Gaussian of the scene; what is not much larger is trusted.
  static SurfaceKernel for_tool(double a_min, double detail, double extent);
};

/// A structure of arrays in single precision. Lengths are in units of SurfaceKernel::detail and relative to
/// the centre of the solid, vectors along the axes of the world. Behind the last contact are some of weight
/// zero, so that whole vectors can be read.
class SurfaceContacts {
 public:
  enum Lane : std::size_t {
    /// Where the surface is. A Gaussian that is thinner than the detail is a sample of it, at Contact::point;
    /// a
    /// thicker one is a solid of its own: of half the thickness h along the normal n, in units of the detail,
    /// the
    /// point is moved along n by h^2 / (1 + h^2) of its way to the plane that touches the Gaussian there.
    kPointX,
    kPointY,
    kPointZ,
    kNormalX,  ///< Contact::normal
    kNormalY,
    kNormalZ,
    kCenterX,  ///< Contact::center
    kCenterY,
    kCenterZ,
    kOverlap,  ///< Contact::k_min
    kOpacity,
    kDepth,
    kExtent,
    /// alpha S(K) / (1 + (h / thickness)^4), h half the Gaussian's thickness along the normal.
    kWeight,
    /// What the Gaussian, seen as a Gaussian of variance s^2 in the tangent plane, covers of the kernel's
    /// disc when both are centred: s^2 / (1 + s^2), times what its thickness leaves.
    kCoverage,
    kNarrowness,  ///< 1 / (1 + s^2): of the product of both
    kExplained,   ///< the most that a patch has made of it, in [0, 1]
    kLaneCount
  };

  /// Room for `capacity` contacts; more take memory from the heap.
  explicit SurfaceContacts(std::size_t capacity);

  /// \param larger the solid enlarged by SurfaceKernel::reach, whose contacts they are
  void assign(std::span<const Contact> contacts, const Ellipsoid& larger, const SurfaceKernel& kernel);

  std::size_t size() const { return size_; }
  /// Of the contacts, by number.
  float* lane(Lane lane) { return &values_[lane * stride_]; }
  const float* lane(Lane lane) const { return &values_[lane * stride_]; }
  /// Contact::normal of one.
  Eigen::Vector3d normal(std::size_t i) const {
    return Eigen::Vector3f(lane(kNormalX)[i], lane(kNormalY)[i], lane(kNormalZ)[i])
        .cast<double>()
        .normalized();
  }

 private:
  std::size_t size_ = 0;
  std::size_t stride_;
  std::vector<float> values_;
};

/// Where the surface is fitted, in the units of SurfaceContacts: a point and an orthonormal frame.
struct SurfaceFrame {
  Eigen::Vector3f origin;
  Eigen::Vector3f u, v;  ///< tangents
  Eigen::Vector3f n;     ///< normal
};

/// Sums over contacts, with w = weight B(normal . n) g(|(x, y)|^2), B how much a contact of that normal
/// belongs to the patch (wholly within 53 degrees, not at all from 78 degrees on: at two deviations of the
/// kernel normals differ by some 45 degrees, and by 90 across a corner of a box), g(r) = max(0, 1 - r / 10)^3
/// the kernel and (x, y, z) the contact's point in the frame.
struct SurfaceMoments {
  /// Of w b_i b_j with b = (1, x, y, x^2 + y^2): the upper triangle, row by row.
  std::array<float, 10> normal_matrix{};
  std::array<float, 4> right{};  ///< of w b_i z
  float heaviest = 0.0F;         ///< the largest w
  float layers = 0.0F;           ///< how many Gaussians lie over each other here, on average over the kernel
  float opacity = 0.0F;          ///< of these, times their opacity
};

/// The sums over all contacts; what each has of this patch goes into SurfaceContacts::kExplained.
SurfaceMoments surface_moments(SurfaceContacts& contacts, const SurfaceFrame& frame);

}  // namespace palpate
