/// \file
/// Contacts and the contact query interface.
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

/// Contact of the tool with one Gaussian. Vectors in the world frame.
struct Contact {
  std::uint32_t id = 0;    ///< row of the Gaussian in the scene file
  std::uint32_t part = 0;  ///< ellipsoid of a multi-part tool; a query leaves it at 0
  double k_min = 0.0;      ///< min K in (0, 1]: 0 at first touch, 1 when the centres coincide
  double lambda = 0.0;     ///< argmin of K, in [0, 1]
  double opacity = 0.0;    ///< alpha in (0, 1]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the Gaussian. Unit: [m].
  /// m(lambda) of paper eq. 5: a point inside both solids; the point of tangency if they only touch. Unit:
  /// [m].
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Unit vector along the negative gradient of K, out of the Gaussian towards the tool. If the centres
  /// coincide, the axis of either solid along which the two are thinnest.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  /// Distance by which the tool must move along `normal` until a plane perpendicular to it separates the two:
  /// h_tool(n) + h_gaussian(n) - n . (c_tool - c_gaussian), h the support function. Exact at first touch and
  /// never less than the true separating translation. Unit: [m].
  double depth = 0.0;
  /// Size of the Gaussian: the root of the sum of the squares of its semi-axes, in single precision. Unit:
  /// [m].
  double extent = 0.0;
};

/// All contacts of one pose, with the counts of the preceding stages. Their order is that of the index that
/// found them, the same for a fresh query and a ContactTracker.
struct ContactSet {
  std::size_t candidates = 0;  ///< Gaussians that passed the broad phase
  std::size_t filtered = 0;    ///< of these, those that passed the bounding spheres (paper eq. 4)
  std::vector<Contact> contacts;
  bool complete = true;  ///< false: there may be more, beyond the QueryLimit

  /// Largest k_min; 0 without contact.
  double k_max() const;
  void clear();
};

/// The contact of a pair whose K is `k` with minimum `minimum`; id and opacity are left alone.
Contact make_contact(const WhitenedTool& tool, const Ellipsoid& gaussian, const KFunction& k,
                     const KMinimum& minimum);

/// Paper eq. 4: true if the bounding spheres overlap. Enlarged by more than the rounding error, so that
/// touching spheres are never separated.
inline bool spheres_overlap(const Ellipsoid& a, double radius_a, const Ellipsoid& b, double radius_b) {
  constexpr double kEnlarged = 16.0 * std::numeric_limits<double>::epsilon();
  const double reach = radius_a + radius_b;
  return (a.center - b.center).squaredNorm() < reach * reach * (1.0 + kEnlarged);
}

/// No limit.
inline constexpr std::size_t kAllPairs = std::numeric_limits<std::size_t>::max();

/// Limits at which a query stops early; ContactSet::complete is then false. It stops after its current batch
/// of pairs, some hundred.
struct QueryLimit {
  std::size_t pairs = kAllPairs;     ///< pairs tested: a bound on the time
  std::size_t contacts = kAllPairs;  ///< contacts found: 1 to know whether there is any
};

/// Precision of the contact's values. Which pairs are contacts does not depend on it.
enum class Precision {
  kDouble,  ///< K_min and opacity to 1e-14, lambda and vectors to 1e-10 or so; K_min of a flat Gaussian
            ///< that is touched off its centre to 1e-15 times its size in tool radii
  kSingle,  ///< K_min to 2e-6, vectors to some 1e-6 of the tool's size: below perception, in two
            ///< thirds of the time
};

struct ContactColumns;

/// Finds the Gaussians that a tool touches. Any number of threads may query concurrently, each with its own
/// result; not while another object is assigned to this one.
class ContactQuery {
 public:
  ContactQuery();
  virtual ~ContactQuery() = default;

  /// Replaces the contents of `result` by the contacts of `tool`.
  /// \pre the semi-axes of `tool` are positive and all of it is finite.
  virtual void query(const Ellipsoid& tool, ContactSet& result) const = 0;

  /// Replaces the contents of `result` by the contacts of all `tools`, tool by tool, as query() finds them.
  /// Calls query() in parallel on the calling thread's oneTBB arena; pipelines with another way to process
  /// many tools override this. The result does not depend on the number of threads. \pre as query() for every
  /// tool.
  virtual void query_batch(std::span<const Ellipsoid> tools, ContactColumns& result) const;

  /// Identifies the data that results belong to: results of one epoch are valid for that epoch only. A
  /// positive number, unique in this process except for copies, which give the same results. A cache stores
  /// the epoch with its results, and detects by it that another query was assigned to the object they came
  /// from.
  virtual std::uint64_t epoch() const { return epoch_; }

 private:
  std::uint64_t epoch_;
};

}  // namespace palpate
