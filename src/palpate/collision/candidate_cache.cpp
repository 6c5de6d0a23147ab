#include <palpate/collision/candidate_cache.h>

#include <algorithm>
#include <cmath>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {
namespace {

/// Tolerance for the rounding of holds().
constexpr double kRounding = 1e-10;

}  // namespace

CandidateCache::CandidateCache(std::size_t capacity) : candidates_(std::make_unique<CandidateSet>(capacity)) {
  static_assert(kCapacity == CandidateSet::kCapacity && kLeastCapacity == CandidateSet::kLeastCapacity);
}

std::size_t CandidateCache::capacity_for(std::size_t solids) {
  constexpr std::size_t kTogether = 16 * kCapacity;
  return std::clamp(kTogether / solids, kLeastCapacity, kCapacity);
}

CandidateCache::~CandidateCache() = default;

bool CandidateCache::search(const SceneIndex& index, const Ellipsoid& solid, Precision precision) {
  center_ = solid.center;
  W_ = WhitenedTool(solid).W;
  const bool fits = find_candidates(index.view(), ToolFrame(solid, index.frame()), precision, *candidates_);
  walked_ = candidates_->walked;
  passed_ = candidates_->passed;
  remember(index, fits);
  return fits;
}

bool CandidateCache::search_drawn(const SceneIndex& index, const Ellipsoid& solid, std::size_t most) {
  const ToolFrame frame(solid, index.frame());
  const Eigen::Matrix3d W = WhitenedTool(solid).W;
  walked_ = passed_ = 0;
  if (under_way_ != index.epoch() || center_ != solid.center || W_ != W) {
    // Finding a grain takes most of a search, and the last one may still be suitable.
    guesses_ = epoch_ == index.epoch();
    begin_search(index.view(), guesses_ ? candidates_->grain : 0.0F, *candidates_);
    under_way_ = index.epoch();
    epoch_ = crowded_ = 0;
    center_ = solid.center;
    W_ = W;
  }
  while (true) {
    const bool through = find_magnified(index.view(), frame, kDrawn, most, *candidates_);
    walked_ += candidates_->walked;
    passed_ += candidates_->passed;
    if (!through) return false;
    if (!guesses_ || candidates_->grain == 0.0F || 2 * candidates_->size > candidates_->capacity) break;
    guesses_ = false;  // the grain was too large
    begin_search(index.view(), 0.0F, *candidates_);
  }
  remember(index, true);
  return true;
}

void CandidateCache::remember(const SceneIndex& index, bool fits) {
  ++searches_;
  epoch_ = fits ? index.epoch() : 0;
  crowded_ = fits ? 0 : index.epoch();
  under_way_ = 0;
}

/// With the solid as the unit sphere, the tool is { c + M u : |u| <= 1 }, which is inside the sphere of
/// radius |c| + ||M||_2; ||M||_2^2 is the largest eigenvalue of M^T M, at most its largest row sum.
bool CandidateCache::holds(const Ellipsoid& tool) const {
  const Eigen::Vector3d c = W_ * (tool.center - center_);
  const Eigen::Matrix3d M = W_ * tool.axes;
  const double largest = (M.transpose() * M).cwiseAbs().rowwise().sum().maxCoeff();
  return c.norm() + std::sqrt(largest) <= 1.0 - kRounding;
}

bool CandidateCache::covers(const SceneIndex& index, const Ellipsoid& tool) const {
  return epoch_ == index.epoch() && holds(tool);
}

bool CandidateCache::is_crowded_around(const SceneIndex& index, const Ellipsoid& tool) const {
  return crowded_ == index.epoch() && holds(tool);
}

void CandidateCache::contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision,
                              QueryLimit limit, ContactSet& result) {
  contacts_among(*candidates_, index.view(), ToolFrame(tool, index.frame()), precision, limit, result);
}

void CandidateCache::splats(const SceneIndex& index, LocalSplats& result) const {
  fill_splats(*candidates_, index.frame(), kDrawn, result);
}

std::size_t CandidateCache::size() const { return candidates_->size; }

}  // namespace palpate
