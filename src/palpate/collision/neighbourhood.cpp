#include <palpate/collision/neighbourhood.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {
namespace {

/// For the rounding of covers().
constexpr double kRounding = 1e-10;

}  // namespace

Neighbourhood::Neighbourhood() : candidates_(std::make_unique<CandidateSet>()) {}

Neighbourhood::~Neighbourhood() = default;

bool Neighbourhood::search(const SceneIndex& index, const Ellipsoid& solid, Precision precision) {
  remember(solid, find_candidates(index.view(), ToolFrame(solid, index.frame()), precision, *candidates_));
  return valid_;
}

bool Neighbourhood::search_drawn(const SceneIndex& index, const Ellipsoid& solid) {
  remember(solid, find_magnified(index.view(), ToolFrame(solid, index.frame()), kDrawn, *candidates_));
  return valid_;
}

void Neighbourhood::remember(const Ellipsoid& solid, bool fits) {
  ++searches_;
  valid_ = fits;
  center_ = solid.center;
  W_ = WhitenedTool(solid).W;
}

/// Seen from where the solid is the unit sphere, the tool is { c + M u : |u| <= 1 }, which is inside the
/// sphere of radius |c| + ||M||_2; ||M||_2^2 is the largest eigenvalue of M^T M, at most its largest row sum.
bool Neighbourhood::covers(const Ellipsoid& tool) const {
  if (!valid_) return false;
  const Eigen::Vector3d c = W_ * (tool.center - center_);
  const Eigen::Matrix3d M = W_ * tool.axes;
  const double largest = (M.transpose() * M).cwiseAbs().rowwise().sum().maxCoeff();
  return c.norm() + std::sqrt(largest) <= 1.0 - kRounding;
}

void Neighbourhood::contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision,
                             ContactSet& result) {
  contacts_among(*candidates_, index.view(), ToolFrame(tool, index.frame()), precision, result);
}

void Neighbourhood::splats(const SceneIndex& index, LocalSplats& result) const {
  static_assert(LocalSplats::kCapacity >= CandidateSet::kCapacity);
  const CandidateSet& from = *candidates_;
  const CapturedFrame& frame = index.frame();
  result.size = from.size;
  const Eigen::Matrix3f turn = frame.world_from_captured.cast<float>();
  for (std::size_t i = 0; i < from.size; ++i) {
    const Eigen::Vector3f captured(from.center[0][i], from.center[1][i], from.center[2][i]);
    const Eigen::Vector3d center = frame.world_from_captured * captured.cast<double>() + frame.origin;
    Eigen::Matrix3f axes;
    for (std::size_t k = 0; k < 9; ++k) axes(static_cast<Eigen::Index>(k)) = from.rounded_axes[k][i];
    axes = turn * (axes / kDrawn);
    const Eigen::Vector3f lengths = axes.colwise().norm();
    const float longest = lengths.maxCoeff(), least = LocalSplats::kLeastThickness * longest;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto lane = static_cast<std::size_t>(k);
      result.center[lane][i] = center[k];
      // Two axes of no length at all leave the direction of the others open.
      const Eigen::Vector3f along =
          lengths[k] > 0.0F
              ? Eigen::Vector3f(axes.col(k) / lengths[k])
              : Eigen::Vector3f(axes.col((k + 1) % 3).cross(axes.col((k + 2) % 3)).normalized());
      for (Eigen::Index j = 0; j < 3; ++j)
        result.whitening[3 * lane + static_cast<std::size_t>(j)][i] = along[j] / std::max(lengths[k], least);
    }
    result.radius[i] = longest;
    result.opacity[i] = static_cast<float>(from.label[i].opacity);
    result.id[i] = from.label[i].id;
  }
}

std::size_t Neighbourhood::size() const { return candidates_->size; }

}  // namespace palpate
