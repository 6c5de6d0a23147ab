/// \file
/// Candidate cache of a moving tool: the Gaussians near it, reused for subsequent poses.
#pragma once

#include <cstdint>
#include <memory>

#include <palpate/collision/local_splats.h>
#include <palpate/collision/scene_index.h>

namespace palpate {

struct CandidateSet;

/// Caches the Gaussians that a solid touches, and where their K was least: sufficient to find the contacts of
/// every tool inside that solid. No heap allocation after construction.
class CandidateCache {
 public:
  /// \param capacity maximum number of Gaussians, see capacity_for()
  explicit CandidateCache(std::size_t capacity = kCapacity);
  ~CandidateCache();

  /// Default capacity, for a single solid.
  static constexpr std::size_t kCapacity = 4096;
  /// Minimum capacity for a search.
  static constexpr std::size_t kLeastCapacity = 1024;
  /// Capacity per solid for `solids` that are near each other: together they keep no more than sixteen single
  /// ones, but each has at least kLeastCapacity.
  static std::size_t capacity_for(std::size_t solids);

  /// Least enlargement of a moving tool for a search, relative to its radii: 0.4 mm for a ball of 20 mm, two
  /// ticks of a fast hand (0.2 m/s). A larger margin keeps more: with 0.1, ticks among dense Gaussians take a
  /// third longer in the median and two thirds longer at p99.9. A smaller one searches more often: with 0.005
  /// these improve by another tenth, and p99 on a sparse scene rises by a quarter. ContactTracker enlarges by
  /// more where that costs less.
  static constexpr double kMargin = 0.02;

  /// Searches the Gaussians that `solid` touches. \returns false if they exceed the capacity; the cache then
  /// covers nothing.
  bool search(const SceneIndex& index, const Ellipsoid& solid, Precision precision);

  /// Searches the Gaussians that splatting draws in `solid`: those whose ellipsoids, enlarged kDrawn times,
  /// touch it, or a sample of them that fits; see find_magnified(). For splats() only. Visits `most`
  /// Gaussians and a few more. \returns false if there are more: the next call with the same solid, in an
  /// index of the same epoch, continues. Until then the cache covers nothing.
  bool search_drawn(const SceneIndex& index, const Ellipsoid& solid, std::size_t most = kAllPairs);

  /// Standard deviations at which splatting stops drawing a Gaussian: 0.99 exp(-3^2 / 2) is 0.011.
  static constexpr float kDrawn = 3.0F;

  /// True if contacts() of `tool` in `index` are complete: never if `index` has another epoch than the one
  /// searched. May be false even though they are.
  bool covers(const SceneIndex& index, const Ellipsoid& tool) const;
  /// True if the last search() around `tool` in `index` exceeded the capacity.
  bool is_crowded_around(const SceneIndex& index, const Ellipsoid& tool) const;

  /// Finds the contacts of `tool` among the cached Gaussians, equal to those of a fresh query up to rounding.
  /// The arguments are those of search(). \pre `index` has the epoch that was searched
  void contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision, QueryLimit limit,
                ContactSet& result);

  /// The cached Gaussians as splatting draws them. \pre search_drawn() was the last search, of that epoch
  void splats(const SceneIndex& index, LocalSplats& result) const;

  /// Number of searches so far; the contents are unchanged while this is.
  std::uint64_t searches() const { return searches_; }

  /// Number of Gaussians cached.
  std::size_t size() const;
  /// \name Cost of the last search call.
  /// @{
  std::size_t walked() const { return walked_; }  ///< Gaussians visited
  std::size_t passed() const {
    return passed_;
  }  ///< those of them tested closely
     /// @}

 private:
  bool holds(const Ellipsoid& tool) const;
  void remember(const SceneIndex& index, bool fits);

  std::unique_ptr<CandidateSet> candidates_;
  std::uint64_t epoch_ = 0;      ///< of the index searched; 0: covers nothing
  std::uint64_t crowded_ = 0;    ///< of the index in which search() exceeded the capacity; 0: none
  std::uint64_t under_way_ = 0;  ///< of the index of an unfinished search_drawn(); 0: none
  bool guesses_ = false;         ///< the grain of that search
  std::size_t walked_ = 0, passed_ = 0;
  std::uint64_t searches_ = 0;
  Eigen::Vector3d center_;  ///< of the solid
  Eigen::Matrix3d W_;       ///< world to the frame where the solid is the unit sphere
};

}  // namespace palpate
