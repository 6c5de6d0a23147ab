#include <palpate/collision/contact_tracker.h>

namespace palpate {
namespace {

/// How much larger the tool is made for a search, in tool radii. A tenth of the default tool is 2 mm, ten
/// ticks of a hand that is quick (0.2 m/s); a smaller margin searches more often, a larger one keeps more
/// Gaussians.
constexpr double kMargin = 0.1;

}  // namespace

ContactTracker::ContactTracker(const SceneIndex& index, Precision precision, Lookahead* lookahead,
                               std::size_t capacity)
    : index_(index),
      precision_(precision),
      ahead_(lookahead == nullptr ? nullptr : &lookahead->add(index, precision, capacity)),
      near_(capacity) {}

void ContactTracker::query(const Ellipsoid& tool, ContactSet& result, std::size_t most) {
  Neighbourhood* known = &near_;
  if (ahead_ != nullptr) {
    ahead_->want(tool);
    if (ahead_->newest().covers(tool)) known = &ahead_->newest();
  }
  if (!known->covers(tool) &&
      !known->search(index_, {tool.center, (1.0 + kMargin) * tool.axes}, precision_)) {
    index_.query(tool, precision_, result, most);  // too crowded to keep
    return;
  }
  known->contacts(index_, tool, precision_, most, result);
}

}  // namespace palpate
