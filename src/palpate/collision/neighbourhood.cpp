#include <palpate/collision/neighbourhood.h>

#include <algorithm>
#include <cmath>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {
namespace {

/// For the rounding of covers().
constexpr double kRounding = 1e-10;

}  // namespace

Neighbourhood::Neighbourhood(std::size_t capacity) : candidates_(std::make_unique<CandidateSet>(capacity)) {
  static_assert(kCapacity == CandidateSet::kCapacity);
}

std::size_t Neighbourhood::capacity_for(std::size_t solids) {
  constexpr std::size_t kTogether = 16 * kCapacity;
  return std::clamp(kTogether / solids, CandidateSet::kLeastCapacity, kCapacity);
}

Neighbourhood::~Neighbourhood() = default;

bool Neighbourhood::search(const SceneIndex& index, const Ellipsoid& solid, Precision precision) {
  const bool fits = find_candidates(index.view(), ToolFrame(solid, index.frame()), precision, *candidates_);
  remember(index, solid, fits);
  return fits;
}

void Neighbourhood::search_drawn(const SceneIndex& index, const Ellipsoid& solid) {
  find_magnified(index.view(), ToolFrame(solid, index.frame()), kDrawn, *candidates_);
  remember(index, solid, true);
}

void Neighbourhood::remember(const SceneIndex& index, const Ellipsoid& solid, bool fits) {
  ++searches_;
  epoch_ = fits ? index.epoch() : 0;
  center_ = solid.center;
  W_ = WhitenedTool(solid).W;
}

/// Seen from where the solid is the unit sphere, the tool is { c + M u : |u| <= 1 }, which is inside the
/// sphere of radius |c| + ||M||_2; ||M||_2^2 is the largest eigenvalue of M^T M, at most its largest row sum.
bool Neighbourhood::covers(const SceneIndex& index, const Ellipsoid& tool) const {
  if (epoch_ != index.epoch()) return false;
  const Eigen::Vector3d c = W_ * (tool.center - center_);
  const Eigen::Matrix3d M = W_ * tool.axes;
  const double largest = (M.transpose() * M).cwiseAbs().rowwise().sum().maxCoeff();
  return c.norm() + std::sqrt(largest) <= 1.0 - kRounding;
}

void Neighbourhood::contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision,
                             std::size_t most, ContactSet& result) {
  contacts_among(*candidates_, index.view(), ToolFrame(tool, index.frame()), precision, most, result);
}

void Neighbourhood::splats(const SceneIndex& index, LocalSplats& result) const {
  fill_splats(*candidates_, index.frame(), kDrawn, result);
}

std::size_t Neighbourhood::size() const { return candidates_->size; }

std::size_t Neighbourhood::walked() const { return candidates_->walked; }

}  // namespace palpate
