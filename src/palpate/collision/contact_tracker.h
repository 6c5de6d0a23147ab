/// \file
/// The contact query for a tool that moves little from tick to tick.
#pragma once

#include <memory>

#include <palpate/collision/scene_index.h>

namespace palpate {

struct CandidateSet;

/// The contacts of SceneIndex::query, found faster where poses follow each other closely: it keeps the
/// Gaussians that a slightly larger tool touched, with where their K was least, and looks no further while
/// the tool stays inside that larger one. However the tool moves, the contacts are those of a fresh query:
/// the same ids, and figures that differ by rounding alone.
///
/// Holds what it found near the last poses and so belongs to one thread; the index must outlive it. Takes
/// nothing from the heap after construction, but for a `result` that is too small.
class ContactTracker {
 public:
  explicit ContactTracker(const SceneIndex& index, Precision precision = Precision::kDouble);
  ~ContactTracker();

  /// Replaces `result` by the contacts of `tool`. ContactSet::candidates is that of the last search,
  /// `filtered` the number of Gaussians it left. \pre as ContactQuery::query.
  void query(const Ellipsoid& tool, ContactSet& result);

 private:
  bool covers(const Ellipsoid& tool) const;
  bool search(const Ellipsoid& tool);

  const SceneIndex& index_;
  Precision precision_;
  std::unique_ptr<CandidateSet> candidates_;
  bool valid_ = false;   ///< candidates_ holds what `reference_`, enlarged, may touch
  Ellipsoid reference_;  ///< the tool at the last search
  Eigen::Matrix3d W_;    ///< world to whitened by reference_
};

}  // namespace palpate
