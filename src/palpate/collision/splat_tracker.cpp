#include <palpate/collision/splat_tracker.h>

#include <algorithm>

namespace palpate {
namespace {

/// How much larger the solid is made for a search, in its own radii; see ContactTracker.
constexpr double kMargin = 0.1;
/// Of a solid that touches too many Gaussians, this much is left at each attempt to find fewer, and a part of
/// it at least.
constexpr double kSmaller = 0.7;
constexpr double kSmallest = 0.01;

}  // namespace

SplatTracker::SplatTracker(const SceneIndex& index, Lookahead* lookahead)
    : index_(index),
      ahead_(lookahead == nullptr ? nullptr : &lookahead->add_drawn(index)),
      splats_(std::make_unique<LocalSplats>()) {}

const LocalSplats& SplatTracker::around(const Ellipsoid& solid) {
  const Neighbourhood* known = &near_;
  if (ahead_ != nullptr) {
    ahead_->want(solid);
    if (ahead_->newest().covers(solid)) known = &ahead_->newest();
  }
  // Where it is crowded, what was enough for the last search is, until that must be left.
  if (!known->covers({solid.center, share_ * solid.axes})) {
    known = &near_;
    share_ = std::min(1.0, share_ / kSmaller);
    while (!near_.search_drawn(index_, {solid.center, (1.0 + kMargin) * share_ * solid.axes}) &&
           share_ > kSmallest)
      share_ *= kSmaller;
  }
  taken_up_ = 0;
  if (known != filled_from_ || known->searches() != filled_at_) fill_from(*known);
  return *splats_;
}

void SplatTracker::fill_from(const Neighbourhood& known) {
  known.splats(index_, *splats_);
  filled_from_ = &known;
  filled_at_ = known.searches();
  taken_up_ = splats_->size;
}

}  // namespace palpate
