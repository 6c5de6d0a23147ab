/// \file
/// The Gaussians around a tool that moves little from tick to tick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/local_splats.h>
#include <palpate/collision/lookahead.h>

namespace palpate {

/// Keeps the LocalSplats of a slightly larger solid, and looks no further while the solid stays inside that.
/// With a Lookahead, another thread looks further. Belongs to one thread; the index must outlive it, and may
/// become another as that of a ContactTracker may. Takes nothing from the heap after construction.
class SplatTracker {
 public:
  /// `lookahead` must outlive it; null: it looks for itself. \param capacity see CandidateCache
  explicit SplatTracker(const SceneIndex& index, Lookahead* lookahead = nullptr,
                        std::size_t capacity = CandidateCache::kCapacity);

  /// All Gaussians that splatting draws something of inside `solid` (CandidateCache::kDrawn), and some
  /// besides; the same until the next call. Where they are more than LocalSplats has room for, a sample that
  /// hides as much; see find_magnified(). \pre as ContactQuery::query.
  const LocalSplats& around(const Ellipsoid& solid) {
    update(solid, kAllPairs);
    return newest();
  }
  /// The same in portions: goes through `most` Gaussians of the index and a few besides. \returns true if
  /// newest() is now what is around `solid`; false if there are more to go through, which the next call with
  /// the same solid does.
  bool update(const Ellipsoid& solid, std::size_t most);
  /// What was found last, of the index that there was then.
  const LocalSplats& newest() const { return *splats_; }
  /// How many Gaussians the last call took up anew; none if what it had was enough.
  std::size_t taken_up() const { return taken_up_; }
  /// True if the last call had to search.
  bool has_searched() const { return has_searched_; }
  /// \name What that cost, see CandidateCache.
  /// @{
  std::size_t walked() const { return has_searched_ ? near_.walked() : 0; }
  std::size_t passed() const { return has_searched_ ? near_.passed() : 0; }
  /// @}

 private:
  void fill_from(const CandidateCache& known);

  const SceneIndex& index_;
  Lookahead::Line* ahead_;
  CandidateCache near_;
  const CandidateCache* filled_from_ = nullptr;
  std::uint64_t filled_at_ = 0;  ///< CandidateCache::searches() then
  std::size_t taken_up_ = 0;
  bool has_searched_ = false;
  std::unique_ptr<LocalSplats> splats_;
};

}  // namespace palpate
