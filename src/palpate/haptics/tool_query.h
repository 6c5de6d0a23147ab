/// \file
/// The contacts of a tool of many ellipsoids.
#pragma once

#include <deque>

#include <palpate/collision/contact_tracker.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Replaces `result` by the contacts of all parts of `tool` at `pose`, X_WT, part by part (Contact::part);
/// counts are sums. A Gaussian that two parts touch is there twice. Takes memory from the heap if there are
/// many parts.
void query(const ContactQuery& contacts, const Tool& tool, const Pose& pose, ContactSet& result);

/// The same for a tool that moves little from tick to tick; see ContactTracker.
class ToolTracker {
 public:
  /// `index` and `lookahead` must outlive it; see ContactTracker. More than kRoom contacts of a part at once
  /// take memory from the heap.
  ToolTracker(const SceneIndex& index, const Tool& tool, Precision precision = Precision::kDouble,
              Lookahead* lookahead = nullptr);

  /// Pairs that a tick has time for, and contacts that come of so many, with those of a last buffer.
  static constexpr std::size_t kMost = 4096, kRoom = kMost + 256;

  /// As query(), of the tool at `pose`. \param most pairs to look at, of all parts together: then those that
  /// come first, and ContactSet::complete is false
  void query(const Pose& pose, ContactSet& result, std::size_t most = kAllPairs);

 private:
  Tool tool_;
  std::deque<ContactTracker> trackers_;  ///< one a part; they cannot be moved
  ContactSet of_part_;
};

}  // namespace palpate
