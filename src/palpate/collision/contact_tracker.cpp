#include <palpate/collision/contact_tracker.h>

namespace palpate {

ContactTracker::ContactTracker(const SceneIndex& index, Precision precision, Lookahead* lookahead,
                               std::size_t capacity)
    : index_(index),
      precision_(precision),
      ahead_(lookahead == nullptr ? nullptr : &lookahead->add(index, precision, capacity)),
      near_(capacity) {}

void ContactTracker::query(const Ellipsoid& tool, ContactSet& result, QueryLimit limit) {
  searched_ = 0;
  if (ahead_ != nullptr) ahead_->want(index_, tool);
  if (ahead_ != nullptr && ahead_->newest().covers(index_, tool)) {
    ahead_->newest().contacts(index_, tool, precision_, limit, result);
  } else if (knows(tool)) {
    near_.contacts(index_, tool, precision_, limit, result);
  } else {
    index_.query(tool, precision_, result, limit);
  }
}

bool ContactTracker::knows(const Ellipsoid& tool) {
  if (near_.covers(index_, tool)) return true;
  if (near_.is_crowded_around(index_, tool)) return false;
  const bool fits =
      near_.search(index_, {tool.center, (1.0 + CandidateCache::kMargin) * tool.axes}, precision_);
  searched_ = near_.passed();
  return fits;
}

}  // namespace palpate
