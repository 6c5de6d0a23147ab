#include <palpate/collision/lookahead.h>

#include <algorithm>
#include <utility>

#include <palpate/geometry/solids.h>

namespace palpate {
namespace {

/// Rounds that a neighbourhood must last: its search, its use until the next, and one to spare.
constexpr double kRounds = 3.0;
/// After so many halvings a margin is negligible.
constexpr int kMostHalvings = 6;

/// Distance from the last search, relative to the margin, within which no other search is needed.
constexpr double kNear = 0.25;

}  // namespace

/// At most one index is in transit, so that the buffer overwritten here is empty.
void Lookahead::Line::want(const SceneIndex& index, const Ellipsoid& tool) {
  if (index.epoch() != told_ && taken_.load(std::memory_order_relaxed) == told_) {
    next_.back() = index;
    next_.publish();
    told_ = index.epoch();
  }
  wanted_.back() = tool;
  wanted_.publish();
  found_.update();
}

void Lookahead::Line::take() {
  if (next_.update()) {
    index_ = *std::move(next_.front());
    next_.front().reset();
    taken_.store(index_.epoch(), std::memory_order_relaxed);
  }
  if (!wanted_.update()) return;
  const Ellipsoid& now = wanted_.front();
  way_ = started_ ? Eigen::Vector3d(now.center - tool_.center) : Eigen::Vector3d::Zero();
  farthest_ = started_ ? way_between(tool_, now) : 0.0;
  tool_ = now;
  started_ = true;
}

void Lookahead::Line::finish() {
  if (!started_) return;
  const double needed = kRounds * farthest_;
  const Ellipsoid ahead{tool_.center + way_, tool_.axes};
  if (known_in_ == index_.epoch() && way_between(known_, ahead) + needed < kNear * margin_) return;
  double margin = std::max(kLeastMargin, needed);
  CandidateCache& found = found_.back();
  for (int k = 0; k < kMostHalvings; ++k) {
    const Ellipsoid solid = enlarged(ahead, margin);
    bool fits = true;
    if (precision_) {
      fits = found.search(index_, solid, *precision_);
    } else {
      found.search_drawn(index_, solid);
    }
    if (fits && (found.size() <= kEasy || margin <= needed)) break;
    margin *= 0.5;
  }
  known_ = ahead;
  known_in_ = index_.epoch();
  margin_ = margin;
  found_.publish();
}

void Lookahead::take() {
  for (Line& line : lines_) line.take();
}

void Lookahead::finish() {
  for (Line& line : lines_) line.finish();
}

}  // namespace palpate
