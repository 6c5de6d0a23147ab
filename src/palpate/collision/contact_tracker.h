/// \file
/// The contact query for a tool that moves little from tick to tick.
#pragma once

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/lookahead.h>

namespace palpate {

/// The contacts of SceneIndex::query, found faster where poses follow each other closely: it keeps the
/// CandidateCache of a slightly larger tool, and looks no further while the tool stays inside that. With a
/// Lookahead, another thread looks further, and farther, before the tool is there.
///
/// However the tool moves, and however late that thread is, the contacts are those of a fresh query: the same
/// ids, and in double the same bits, but for one figure in a hundred thousand, in whose last digits rounding
/// shows where its search began. What is not near enough to be known costs the time of such
/// a query, never its truth.
///
/// Another index may be assigned to the one that it refers to, between two calls on its thread: it answers
/// for that from the next call on, which looks anew. Of one that is assigned in every tick, every tick costs
/// a fresh query and a little. Whoever assigns drops their reference to the memory before, and with the last
/// one all of it: see docs/architecture.md, A scene that changes.
///
/// Belongs to one thread; the index must outlive it. Takes nothing from the heap after construction, but for
/// a `result` that is too small.
class ContactTracker {
 public:
  /// `lookahead` must outlive it; null: it looks for itself. \param capacity see CandidateCache
  explicit ContactTracker(const SceneIndex& index, Precision precision = Precision::kDouble,
                          Lookahead* lookahead = nullptr, std::size_t capacity = CandidateCache::kCapacity);

  /// Replaces `result` by the contacts of `tool`. ContactSet::candidates is that of the last search,
  /// `filtered` the number of Gaussians it left. \pre as ContactQuery::query.
  void query(const Ellipsoid& tool, ContactSet& result, QueryLimit limit = {});
  /// How many Gaussians the last query searched closely; none if it knew what is near.
  std::size_t searched() const { return searched_; }

 private:
  /// Makes near_ cover `tool`. \returns false if too many Gaussians are near to keep them
  bool knows(const Ellipsoid& tool);

  const SceneIndex& index_;
  Precision precision_;
  Lookahead::Line* ahead_;
  CandidateCache near_;
  std::size_t searched_ = 0;
};

}  // namespace palpate
