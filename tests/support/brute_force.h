/// \file
/// Contacts by trying every Gaussian, with the scalar code that tests/collision/k_function*_test.cpp vouch
/// for, and the comparison of a query with them.
#pragma once

#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>

namespace palpate::test {

/// Every contact of `tool`, ordered by id.
std::vector<Contact> brute_force(const EllipsoidScene& scene, const Ellipsoid& tool);

/// The contacts of a query, which come in the order of its index, in the order of their ids. Each must be
/// there once.
std::vector<Contact> in_order(std::vector<Contact> contacts);

/// What a query may differ from brute force by.
struct Bars {
  /// |dK_min|; and pairs nearer to touching than this may be found or not.
  double k = 1e-12;
  /// lambda, normal, and point and depth in tool radii. Not compared if 0, as where K is so flat that
  /// rounding decides where it is least; lambda must then still be where K is K_min, to within `k`.
  double place = 1e-8;
  /// Size of coordinates that come and go on the way, as a far origin. Unit: [m].
  double away = 0.0;
};

/// Two lists of contacts that should be one.
void expect_close(const std::vector<Contact>& found, const std::vector<Contact>& expected,
                  const Ellipsoid& tool, const Bars& bars = {});

/// The same to the last bit.
void expect_equal(const std::vector<Contact>& found, const std::vector<Contact>& expected);

/// What brute force says about many tools, computed once for the queries of all instruction sets.
class BruteForce {
 public:
  BruteForce(const GaussianScene& scene, const SceneFilter& filter, const Similarity& world_from_scene,
             std::vector<Ellipsoid> tools);

  /// Compares `query` with it, and what the stages count. \returns the contacts seen.
  std::size_t check(const ContactQuery& query, const Bars& bars = {}) const;

  const EllipsoidScene& scene() const { return scene_; }
  const std::vector<Ellipsoid>& tools() const { return tools_; }

 private:
  void check_verdicts(const std::vector<Contact>& found, std::size_t tool, const Bars& bars) const;

  EllipsoidScene scene_;
  std::vector<Ellipsoid> tools_;
  std::vector<std::vector<Contact>> contacts_;
};

/// Largest deviations of all comparisons at the usual bars since the program started, for the record.
struct WorstSeen {
  double k = 0.0, place = 0.0;
};
WorstSeen worst_seen();

}  // namespace palpate::test
