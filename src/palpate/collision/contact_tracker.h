/// \file
/// Contact query for a tool that moves little from tick to tick.
#pragma once

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/lookahead.h>

namespace palpate {

/// Returns the contacts of SceneIndex::query, faster where successive poses are close: it keeps the
/// CandidateCache of a slightly enlarged tool and searches the index only when the tool leaves that. With a
/// Lookahead, another thread searches a larger neighbourhood in advance.
///
/// However the tool moves, and however late that thread is, the contacts are those of a fresh query: the same
/// ids, and in double precision the same bits, except for one value in a hundred thousand whose last digits
/// depend, by rounding, on where its minimisation started. A cache miss costs the time of a fresh query,
/// never correctness.
///
/// Another index may be assigned to the referenced one between two calls on this thread: from the next call
/// on, the tracker answers for that and searches anew. If the index is assigned in every tick, every tick
/// costs slightly more than a fresh query. The assignment releases its reference to the previous memory, and
/// the last reference frees it: see docs/architecture.md, A scene that changes.
///
/// Used by one thread; the index must outlive it. No heap allocation after construction, unless `result` is
/// too small.
class ContactTracker {
 public:
  /// `lookahead` must outlive it; null: the tracker searches by itself. \param capacity see CandidateCache
  explicit ContactTracker(const SceneIndex& index, Precision precision = Precision::kDouble,
                          Lookahead* lookahead = nullptr, std::size_t capacity = CandidateCache::kCapacity);

  /// Replaces `result` by the contacts of `tool`. ContactSet::candidates is that of the last search,
  /// `filtered` the number of Gaussians that search kept. \pre as ContactQuery::query.
  void query(const Ellipsoid& tool, ContactSet& result, QueryLimit limit = {});
  /// Number of Gaussians that the last query searched closely; 0 if the cache covered the tool.
  std::size_t searched() const { return searched_; }

 private:
  /// Makes near_ cover `tool`. \returns false if there are too many Gaussians to keep
  bool knows(const Ellipsoid& tool);

  const SceneIndex& index_;
  Precision precision_;
  Lookahead::Line* ahead_;
  CandidateCache near_;
  std::size_t searched_ = 0;
  /// Centre of the tool of the last query; the origin before the first, whose margin is thus any permitted
  /// one.
  Eigen::Vector3d last_center_ = Eigen::Vector3d::Zero();
};

}  // namespace palpate
