/// \file
/// Splats around a tool that moves little from tick to tick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/local_splats.h>
#include <palpate/collision/lookahead.h>

namespace palpate {

/// Keeps the LocalSplats of a slightly enlarged solid and searches the index only when the solid leaves that.
/// With a Lookahead, another thread searches in advance. Used by one thread; the index must outlive it, and
/// may be replaced as that of a ContactTracker may. No heap allocation after construction.
class SplatTracker {
 public:
  /// `lookahead` must outlive it; null: the tracker searches by itself. \param capacity see CandidateCache
  explicit SplatTracker(const SceneIndex& index, Lookahead* lookahead = nullptr,
                        std::size_t capacity = CandidateCache::kCapacity);

  /// All Gaussians that splatting draws inside `solid` (CandidateCache::kDrawn), and some more; valid until
  /// the next call. If they exceed the capacity of LocalSplats, a sample that occludes as much; see
  /// find_magnified(). \pre as ContactQuery::query.
  const LocalSplats& around(const Ellipsoid& solid) {
    update(solid, kAllPairs);
    return newest();
  }
  /// The incremental form of around(): visits `most` Gaussians of the index and a few more. \returns true if
  /// newest() now holds the surroundings of `solid`; false if the search is incomplete: the next call with
  /// the same solid continues it.
  bool update(const Ellipsoid& solid, std::size_t most);
  /// The last result, of the index at that time.
  const LocalSplats& newest() const { return *splats_; }
  /// Number of Gaussians that the last call replaced; 0 if the cached ones covered the solid.
  std::size_t taken_up() const { return taken_up_; }
  /// True if the last call had to search.
  bool has_searched() const { return has_searched_; }
  /// \name Cost of that search, see CandidateCache.
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
  std::uint64_t filled_at_ = 0;  ///< CandidateCache::searches() at that time
  std::size_t taken_up_ = 0;
  bool has_searched_ = false;
  std::unique_ptr<LocalSplats> splats_;
};

}  // namespace palpate
