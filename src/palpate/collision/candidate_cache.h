/// \file
/// The Gaussians near a tool, kept for the poses that follow.
#pragma once

#include <cstdint>
#include <memory>

#include <palpate/collision/local_splats.h>
#include <palpate/collision/scene_index.h>

namespace palpate {

struct CandidateSet;

/// The Gaussians that a solid touches, and where their K was least: enough to answer for every tool inside
/// that solid. Takes nothing from the heap after construction.
class CandidateCache {
 public:
  /// \param capacity Gaussians to keep at most, see capacity_for()
  explicit CandidateCache(std::size_t capacity = kCapacity);
  ~CandidateCache();

  /// For one solid alone.
  static constexpr std::size_t kCapacity = 4096;
  /// What a search needs.
  static constexpr std::size_t kLeastCapacity = 1024;
  /// For each of `solids` that are near each other: so many of them keep no more together than sixteen alone,
  /// until each has kLeastCapacity.
  static std::size_t capacity_for(std::size_t solids);

  /// How much larger a tool that moves is made for a search, in its own radii: 0.4 mm of a ball of 20 mm, two
  /// ticks of a hand that is quick (0.2 m/s). A larger one keeps more: with 0.1, ticks among dense Gaussians
  /// take a third longer in the median and two thirds at p99.9. A smaller one searches more often: with 0.005
  /// these gain another tenth, and p99 on a sparse scene rises by a quarter.
  static constexpr double kMargin = 0.02;

  /// Looks for what `solid` touches. \returns false if that is too much to keep; it then covers nothing.
  bool search(const SceneIndex& index, const Ellipsoid& solid, Precision precision);

  /// The same of what splatting draws: Gaussians whose ellipsoids are kDrawn times as large, or a sample of
  /// them that is not too much; see find_magnified(). For splats() alone. Goes through `most` Gaussians and a
  /// few besides. \returns false if there are more: the next call with the same solid, in an index of the
  /// same epoch, goes on. Until then it covers nothing.
  bool search_drawn(const SceneIndex& index, const Ellipsoid& solid, std::size_t most = kAllPairs);

  /// What is drawn of an ellipsoid of one standard deviation ends here: 0.99 exp(-3^2 / 2) is 0.011.
  static constexpr float kDrawn = 3.0F;

  /// True if contacts() of `tool` in `index` are complete: never if `index` is of another epoch than that
  /// which was searched. May be false though they would be.
  bool covers(const SceneIndex& index, const Ellipsoid& tool) const;
  /// True if search() found too much around `tool` in `index` last.
  bool is_crowded_around(const SceneIndex& index, const Ellipsoid& tool) const;

  /// Those contacts of `tool` that are among it, by rounding the same as of a fresh query. The arguments are
  /// those of search(). \pre `index` is of the epoch that was searched
  void contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision, QueryLimit limit,
                ContactSet& result);

  /// What is kept, as splatting draws it. \pre search_drawn() has been called last, of that epoch
  void splats(const SceneIndex& index, LocalSplats& result) const;

  /// How often it was searched for: what is kept is the same while this is.
  std::uint64_t searches() const { return searches_; }

  /// How many Gaussians are kept.
  std::size_t size() const;
  /// \name What the last call of a search cost.
  /// @{
  std::size_t walked() const { return walked_; }  ///< how many it went through
  std::size_t passed() const {
    return passed_;
  }  ///< how many of them it had to look at closely
     /// @}

 private:
  bool holds(const Ellipsoid& tool) const;
  void remember(const SceneIndex& index, bool fits);

  std::unique_ptr<CandidateSet> candidates_;
  std::uint64_t epoch_ = 0;      ///< of the index that was searched; 0: it covers nothing
  std::uint64_t crowded_ = 0;    ///< of the index in which search() found too much; 0: it did not
  std::uint64_t under_way_ = 0;  ///< of the index that search_drawn() has not been through; 0: it has
  bool guesses_ = false;         ///< the grain of that search
  std::size_t walked_ = 0, passed_ = 0;
  std::uint64_t searches_ = 0;
  Eigen::Vector3d center_;  ///< of the solid
  Eigen::Matrix3d W_;       ///< world to where the solid is the unit sphere
};

}  // namespace palpate
