#include <palpate/collision/splat_tracker.h>

namespace palpate {

SplatTracker::SplatTracker(const SceneIndex& index, Lookahead* lookahead, std::size_t capacity)
    : index_(index),
      ahead_(lookahead == nullptr ? nullptr : &lookahead->add_drawn(index, capacity)),
      near_(capacity),
      splats_(std::make_unique<LocalSplats>(capacity)) {}

bool SplatTracker::update(const Ellipsoid& solid, std::size_t most) {
  const CandidateCache* known = &near_;
  if (ahead_ != nullptr) {
    ahead_->want(index_, solid);
    if (ahead_->newest().covers(index_, solid)) known = &ahead_->newest();
  }
  taken_up_ = 0;
  has_searched_ = false;
  if (!known->covers(index_, solid)) {
    known = &near_;
    has_searched_ = !known->covers(index_, solid);
    const Ellipsoid larger{solid.center, (1.0 + CandidateCache::kMargin) * solid.axes};
    if (has_searched_ && !near_.search_drawn(index_, larger, most)) return false;
  }
  if (known != filled_from_ || known->searches() != filled_at_) fill_from(*known);
  return true;
}

void SplatTracker::fill_from(const CandidateCache& known) {
  known.splats(index_, *splats_);
  filled_from_ = &known;
  filled_at_ = known.searches();
  taken_up_ = splats_->size;
}

}  // namespace palpate
