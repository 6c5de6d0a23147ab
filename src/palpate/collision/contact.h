/// \file
/// What a contact query answers with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <palpate/collision/k_function.h>
#include <palpate/geometry/ellipsoid.h>
#include <palpate/geometry/pose.h>

namespace palpate {

/// One Gaussian that the tool overlaps. Vectors in the world frame.
struct Contact {
  std::uint32_t id = 0;    ///< row of the Gaussian in the scene file
  std::uint32_t part = 0;  ///< which ellipsoid of the tool, where that has many; a query leaves it at 0
  double k_min = 0.0;      ///< min K in (0, 1]: 0 at first touch, 1 when the centres coincide
  double lambda = 0.0;     ///< where K is least, in [0, 1]
  double opacity = 0.0;    ///< alpha in (0, 1]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the Gaussian. Unit: [m].
  /// m(lambda) of paper eq. 5: a point inside both solids; where they touch, if they only touch.
  /// Unit: [m].
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Unit vector against the gradient of K, out of the Gaussian towards the tool: the way out.
  /// If the centres coincide, the axis of either along which the two are thinnest.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// How far the tool must move along `normal` until a plane across it separates the two:
  /// h_tool(n) + h_gaussian(n) - n . (c_tool - c_gaussian), h the support function. Exact at first
  /// touch and never less than the true separating translation. Unit: [m].
  double depth = 0.0;
  /// How large the Gaussian is: the root of the sum of the squares of its semi-axes, in single precision.
  /// Unit: [m].
  double extent = 0.0;
};

/// All contacts of one pose, with the sizes of the stages that led to them. Their order is that of the index
/// that found them, the same for a fresh query and a ContactTracker.
struct ContactSet {
  std::size_t candidates = 0;  ///< Gaussians that the broad phase let through
  std::size_t filtered = 0;    ///< of these, how many passed the bounding spheres (paper eq. 4)
  std::vector<Contact> contacts;
  bool complete = true;  ///< false: there may be more, beyond the QueryLimit

  /// Largest k_min; 0 without contact.
  double k_max() const;
  void clear();
};

/// The contact of a pair whose K is `k` with minimum `minimum`; id and opacity are left alone.
Contact make_contact(const WhitenedTool& tool, const Ellipsoid& gaussian, const KFunction& k,
                     const KMinimum& minimum);

/// Paper eq. 4: true if the bounding spheres overlap. Widened by more than its own rounding, so
/// that spheres that touch are never taken apart.
inline bool spheres_overlap(const Ellipsoid& a, double radius_a, const Ellipsoid& b, double radius_b) {
  constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
  const double reach = radius_a + radius_b;
  return (a.center - b.center).squaredNorm() < reach * reach * (1.0 + kRounding);
}

/// No bound on the pairs that a query looks at.
inline constexpr std::size_t kAllPairs = std::numeric_limits<std::size_t>::max();

/// Where a query stops before it has been through all; ContactSet::complete is then false. It does after the
/// pairs that it is just looking at, some hundred.
struct QueryLimit {
  std::size_t pairs = kAllPairs;     ///< it has looked at so many: a bound on the time
  std::size_t contacts = kAllPairs;  ///< it has found so many: 1 to know whether there is any
};

/// What the figures of a contact are computed in. Which pairs are contacts does not depend on it.
enum class Precision {
  kDouble,  ///< K_min and opacity to 1e-14, lambda and vectors to 1e-10 or so; K_min of a flat Gaussian
            ///< that is touched off its centre to 1e-15 times its size in tool radii
  kSingle,  ///< K_min to 2e-6, vectors to some 1e-6 of the tool's size: all that a hand can tell, in two
            ///< thirds of the time
};

struct ContactColumns;

/// Answers which Gaussians a tool touches. Any number of threads may query at once, each with a result of its
/// own; not while another is assigned to it.
class ContactQuery {
 public:
  ContactQuery();
  virtual ~ContactQuery() = default;

  /// Replaces the contents of `result` by the contacts of `tool`.
  /// \pre the semi-axes of `tool` are positive and all of it is finite.
  virtual void query(const Ellipsoid& tool, ContactSet& result) const = 0;

  /// Replaces the contents of `result` by the contacts of all `tools`, tool by tool, each as query() has
  /// them. Asks query() in parallel on the calling thread's oneTBB arena; a pipeline that answers many tools
  /// at once by other means does so here. The result does not depend on the number of threads. \pre as
  /// query() for every tool.
  virtual void query_batch(std::span<const Ellipsoid> tools, ContactColumns& result) const;

  /// Tells answers apart: what was found in one epoch holds in that alone. A number above 0 that no other
  /// query of this process has, but copies, which answer the same. Whoever keeps answers keeps this with
  /// them, and sees by it that another query has been assigned to the object they came from.
  virtual std::uint64_t epoch() const { return epoch_; }

 private:
  std::uint64_t epoch_;
};

}  // namespace palpate
