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
class Neighbourhood {
 public:
  /// \param capacity Gaussians to keep at most, see capacity_for()
  explicit Neighbourhood(std::size_t capacity = kCapacity);
  ~Neighbourhood();

  /// For one solid alone.
  static constexpr std::size_t kCapacity = 4096;
  /// For each of `solids` that are near each other: so many of them keep no more together than sixteen alone,
  /// until each has the least that a search needs.
  static std::size_t capacity_for(std::size_t solids);

  /// How much larger a tool that moves is made for a search, in its own radii: 0.4 mm of a ball of 20 mm, two
  /// ticks of a hand that is quick (0.2 m/s). A larger one keeps more: with 0.1, ticks among dense Gaussians
  /// take a third longer in the median and two thirds at p99.9. A smaller one searches more often: with 0.005
  /// these gain another tenth, and p99 on a sparse scene rises by a quarter.
  static constexpr double kMargin = 0.02;

  /// Looks for what `solid` touches. \returns false if that is too much to keep; it then covers nothing.
  bool search(const SceneIndex& index, const Ellipsoid& solid, Precision precision);

  /// The same of what splatting draws: Gaussians whose ellipsoids are kDrawn times as large, or a sample of
  /// them that is not too much; see find_magnified(). For splats() alone.
  void search_drawn(const SceneIndex& index, const Ellipsoid& solid);

  /// What is drawn of an ellipsoid of one standard deviation ends here: 0.99 exp(-3^2 / 2) is 0.011.
  static constexpr float kDrawn = 3.0F;

  /// True if contacts() of `tool` in `index` are complete: never if `index` is of another epoch than that
  /// which was searched. May be false though they would be.
  bool covers(const SceneIndex& index, const Ellipsoid& tool) const;

  /// Those contacts of `tool` that are among it, by rounding the same as of a fresh query. The arguments are
  /// those of search(). \param most as of SceneIndex::query \pre `index` is of the epoch that was searched
  void contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision, std::size_t most,
                ContactSet& result);

  /// What is kept, as splatting draws it. \pre search_drawn() has been called last, of that epoch
  void splats(const SceneIndex& index, LocalSplats& result) const;

  /// How often it was searched for: what is kept is the same while this is.
  std::uint64_t searches() const { return searches_; }

  /// How many Gaussians are kept.
  std::size_t size() const;
  /// How many the last search went through: what it cost.
  std::size_t walked() const;

 private:
  void remember(const SceneIndex& index, const Ellipsoid& solid, bool fits);

  std::unique_ptr<CandidateSet> candidates_;
  std::uint64_t epoch_ = 0;  ///< of the index that was searched; 0: it covers nothing
  std::uint64_t searches_ = 0;
  Eigen::Vector3d center_;  ///< of the solid
  Eigen::Matrix3d W_;       ///< world to where the solid is the unit sphere
};

}  // namespace palpate
