#include <palpate/collision/contact_tracker.h>

#include <cmath>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {
namespace {

/// How much larger the tool is made for a search, in tool radii. A tenth of the default tool is 2 mm, ten
/// ticks of a hand that is quick (0.2 m/s); a smaller margin searches more often, a larger one keeps more
/// Gaussians.
constexpr double kMargin = 0.1;
/// Of the margin, for the rounding of covers().
constexpr double kRounding = 1e-9;

}  // namespace

ContactTracker::ContactTracker(const SceneIndex& index, Precision precision)
    : index_(index), precision_(precision), candidates_(std::make_unique<CandidateSet>()) {}

ContactTracker::~ContactTracker() = default;

void ContactTracker::query(const Ellipsoid& tool, ContactSet& result) {
  if (!(valid_ && covers(tool)) && !search(tool)) {
    index_.query(tool, precision_, result);  // too crowded to keep
    return;
  }
  contacts_among(*candidates_, index_.view(), ToolFrame(tool, index_.frame()), precision_, result);
}

/// Seen from the reference, where that is the unit sphere, the tool is { c + M u : |u| <= 1 }, which is
/// inside the sphere of radius |c| + ||M||_2; ||M||_2^2 is the largest eigenvalue of M^T M, at most its
/// largest row sum.
bool ContactTracker::covers(const Ellipsoid& tool) const {
  const Eigen::Vector3d c = W_ * (tool.center - reference_.center);
  const Eigen::Matrix3d M = W_ * tool.axes;
  const double largest = (M.transpose() * M).cwiseAbs().rowwise().sum().maxCoeff();
  return c.norm() + std::sqrt(largest) <= 1.0 + kMargin * (1.0 - kRounding);
}

bool ContactTracker::search(const Ellipsoid& tool) {
  const Ellipsoid larger{tool.center, (1.0 + kMargin) * tool.axes};
  valid_ = find_candidates(index_.view(), ToolFrame(larger, index_.frame()), precision_, *candidates_);
  reference_ = tool;
  W_ = WhitenedTool(tool).W;
  return valid_;
}

}  // namespace palpate
