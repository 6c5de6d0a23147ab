#include <palpate/collision/tool_frame.h>

#include <cmath>
#include <limits>

#include <palpate/collision/two_floats.h>

namespace palpate {
namespace {

constexpr double kFloatRoundoff = 0x1p-24;
constexpr double kDoubleRoundoff = 0x1p-53;

/// Bringing the tool into the captured frame takes a few operations on numbers of the magnitude of the
/// centre, the translation and the origin; the box is padded by more than their rounding.
constexpr double kToolPadding = 128.0 * kDoubleRoundoff;

}  // namespace

CapturedFrame::CapturedFrame(const Similarity& world_from_scene, const Eigen::Vector3d& index_origin)
    : world_from_captured(world_from_scene.scale * world_from_scene.orthogonal()),
      captured_from_world(world_from_scene.orthogonal().transpose() / world_from_scene.scale),
      origin(world_from_captured * index_origin + world_from_scene.translation),
      scale(world_from_scene.scale),
      size(scale * index_origin.norm() + world_from_scene.translation.norm()) {}

ToolFrame::ToolFrame(const Ellipsoid& tool, const CapturedFrame& frame)
    : world(tool),
      W(world.W * frame.world_from_captured),
      center(frame.captured_from_world * (tool.center - frame.origin)),
      scale(frame.scale) {
  const Eigen::Matrix3d axes = frame.captured_from_world * tool.axes;
  const Eigen::Vector3d half = axes.rowwise().norm();
  const double size = (tool.center.norm() + frame.size) / frame.scale;
  const Eigen::Vector3d reach = half + Eigen::Vector3d::Constant(kToolPadding * size);
  // Rounding to single precision is off by half a unit in the last place; a whole one and the smallest number
  // round outwards.
  const Eigen::Vector3d outwards = 2.0 * kFloatRoundoff * (center.cwiseAbs() + reach) +
                                   Eigen::Vector3d::Constant(std::numeric_limits<float>::min());
  // Finite, since the box of an empty slot is infinite and must not overlap.
  constexpr double kLargest = std::numeric_limits<float>::max();
  low = (center - reach - outwards).cwiseMax(-kLargest).cwiseMin(kLargest).cast<float>();
  high = (center + reach + outwards).cwiseMax(-kLargest).cwiseMin(kLargest).cast<float>();

  W_float = W.cast<float>();
  for (int axis = 0; axis < 3; ++axis) split(center[axis], center_high[axis], center_low[axis]);

  // The float lanes compute d = ((center_high - p) + center_low), off by at most 2 u |d| + 2 u^2 |center|,
  // and d' = W d with three products per row: |dd'| <= 6 kappa u |d'| + beta. The square of |d'| has twice
  // that error, its own rounding and that of the reach.
  const double norm = W.norm();  // Frobenius norm, at least the spectral norm
  const Eigen::Vector3d lengths = tool.axes.colwise().norm() / frame.scale;
  const double kappa = norm * lengths.maxCoeff();
  const double beta = norm * 2.0 * kFloatRoundoff * kFloatRoundoff * center.norm();
  metric = (W.transpose() * W).cast<float>();
  const double away = norm * kFloatRoundoff * center.norm();
  box = {static_cast<float>(8.0 * away),
         static_cast<float>(norm * norm * (64.0 * kFloatRoundoff + 8.0 * away))};
  cull_slack = static_cast<float>(2.0 * (12.0 * kappa * kFloatRoundoff + 2.0 * beta + 8.0 * kFloatRoundoff));
  // Spectral norm of W: one over the shortest semi-axis. A length is its larger part and less than a unit in
  // the last place; two more for the rounding of this number.
  reach_per_length = static_cast<float>((1.0 + 6.0 * kFloatRoundoff) / lengths.minCoeff());

  single = {static_cast<float>(2.0 * (14.0 * kFloatRoundoff + 2.0 * beta)),
            static_cast<float>(2.0 * 36.0 * kappa * kFloatRoundoff),
            static_cast<float>(2.0 * 16.0 * kFloatRoundoff)};
  const double eta = lengths.prod() / std::pow(lengths.minCoeff(), 3);
  const double of_one = (14.0 * eta + 34.0) * kDoubleRoundoff;
  const double of_distance = (22.0 * eta + 12.0 * kappa) * kDoubleRoundoff;
  const double of_axes = 64.0 * kappa * kDoubleRoundoff;
  rounded = {40.0F * static_cast<float>(kFloatRoundoff),
             static_cast<float>(2.0 * (of_one + of_distance + of_axes)), 0.0F};
  constexpr double kSquared = 3.0 * 2.0 * 4.0;  // three terms, their effect on g, and doubled
  rounding = {kSquared * of_one * of_one, kSquared * of_distance * of_distance, kSquared * of_axes * of_axes};
}

}  // namespace palpate
