#include <palpate/collision/lookahead.h>

#include <algorithm>

#include <palpate/geometry/solids.h>

namespace palpate {
namespace {

/// A neighbourhood is searched for, and used until the next is there: two rounds, and one to spare.
constexpr double kRounds = 3.0;
/// A margin that is halved as often is as good as none.
constexpr int kMostHalvings = 6;

/// Of the margin: closer to where was searched last, the tool needs no other search.
constexpr double kNear = 0.25;

}  // namespace

void Lookahead::Line::want(const Ellipsoid& tool) {
  wanted_.back() = tool;
  wanted_.publish();
  found_.update();
}

void Lookahead::Line::take() {
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
  if (way_between(known_, ahead) + needed < kNear * margin_) return;
  double margin = std::max(kLeastMargin, needed);
  Neighbourhood& found = found_.back();
  for (int k = 0; k < kMostHalvings; ++k, margin *= 0.5) {
    const Ellipsoid solid = enlarged(ahead, margin);
    bool fits = true;
    if (precision_) {
      fits = found.search(index_, solid, *precision_);
    } else {
      found.search_drawn(index_, solid);
    }
    if (fits && (found.size() <= kEasy || margin <= needed)) break;
  }
  known_ = ahead;
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
