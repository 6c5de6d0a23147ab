/// \file
/// Contact query of a tool of several ellipsoids.
#pragma once

#include <deque>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Replaces `result` by the contacts of all parts of `tool` at `pose`, X_WT, part by part (Contact::part);
/// counts are sums. A Gaussian that two parts touch is listed twice. Allocates if there are many parts.
void query(const ContactQuery& contacts, const Tool& tool, const Pose& pose, ContactSet& result);

/// The same within a bounded time: examines at most `most` pairs, of all parts together; if there are more,
/// ContactSet::complete is false.
void query(const SceneIndex& index, const Tool& tool, const Pose& pose, std::size_t most, ContactSet& result);

/// As the first for a tool that moves little from tick to tick; see ContactTracker.
class ToolTracker {
 public:
  /// `index` and `lookahead` must outlive it; see ContactTracker. Allocates if a part has more than kRoom
  /// contacts at once.
  ToolTracker(const SceneIndex& index, const Tool& tool, Precision precision = Precision::kDouble,
              Lookahead* lookahead = nullptr);

  /// Largest number of pairs for one tick, and of the resulting contacts, including those of a last buffer.
  static constexpr std::size_t kMost = 4096, kRoom = kMost + 256;

  /// As query(), for the tool at `pose`. \param most largest number of pairs to examine, of all parts
  /// together; if exceeded, only the first are examined and ContactSet::complete is false
  void query(const Pose& pose, ContactSet& result, std::size_t most = kAllPairs);

 private:
  Tool tool_;
  std::deque<ContactTracker> trackers_;  ///< one per part; not movable
  ContactSet of_part_;
};

}  // namespace palpate
