#include <palpate/collision/contact_tracker.h>

namespace palpate {

ContactTracker::ContactTracker(const SceneIndex& index, Precision precision, Lookahead* lookahead,
                               std::size_t capacity)
    : index_(index),
      precision_(precision),
      ahead_(lookahead == nullptr ? nullptr : &lookahead->add(index, precision, capacity)),
      near_(capacity) {}

void ContactTracker::query(const Ellipsoid& tool, ContactSet& result, std::size_t most) {
  Neighbourhood* known = &near_;
  if (ahead_ != nullptr) {
    ahead_->want(index_, tool);
    if (ahead_->newest().covers(index_, tool)) known = &ahead_->newest();
  }
  if (!known->covers(index_, tool) &&
      !known->search(index_, {tool.center, (1.0 + Neighbourhood::kMargin) * tool.axes}, precision_)) {
    index_.query(tool, precision_, result, most);  // too crowded to keep
    return;
  }
  known->contacts(index_, tool, precision_, most, result);
}

}  // namespace palpate
