#include <palpate/collision/contact_tracker.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Enlargement of a tool for a search, relative to its radii. A search lasts for about margin / `step` ticks,
/// and the cost of each tick grows with the Gaussians kept, by about `kept` * margin: the sum is least where
/// the margin is proportional to sqrt(step / kept). \param step motion of the tool in a tick, relative to its
/// mean radius \param kept number of Gaussians that the last search kept
double margin_for(double step, std::size_t kept) {
  constexpr double kSearch = 5.0;  // cost of a search in terms of that of a Gaussian kept; measured
  constexpr double kMost = 0.1;
  return std::clamp(std::sqrt(kSearch * step / static_cast<double>(kept + 1)), CandidateCache::kMargin,
                    kMost);
}

}  // namespace

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
  last_center_ = tool.center;
}

bool ContactTracker::knows(const Ellipsoid& tool) {
  if (near_.covers(index_, tool)) return true;
  if (near_.is_crowded_around(index_, tool)) return false;
  const double radius = std::cbrt(std::abs(tool.axes.determinant()));
  const double margin = margin_for((tool.center - last_center_).norm() / radius, near_.size());
  const bool fits = near_.search(index_, {tool.center, (1.0 + margin) * tool.axes}, precision_);
  searched_ = near_.passed();
  return fits;
}

}  // namespace palpate
