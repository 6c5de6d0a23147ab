#include <palpate/collision/local_splats.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/instruction_sets.h>
#include <palpate/collision/tool_frame.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/collision/local_splats.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Transforms centres to the world, in double precision.
void Place(const CandidateSet& from, const CapturedFrame& frame, LocalSplats& result) {
  const hn::CappedTag<double, kIndexWidth> d;
  const hn::Rebind<float, decltype(d)> df;
  const Eigen::Matrix3d& turn = frame.world_from_captured;
  for (std::size_t i = 0; i < from.size; i += hn::Lanes(d)) {
    const auto x = hn::PromoteTo(d, hn::LoadU(df, &from.center[0][i]));
    const auto y = hn::PromoteTo(d, hn::LoadU(df, &from.center[1][i]));
    const auto z = hn::PromoteTo(d, hn::LoadU(df, &from.center[2][i]));
    for (Eigen::Index r = 0; r < 3; ++r) {
      const auto rest = hn::MulAdd(z, hn::Set(d, turn(r, 2)), hn::Set(d, frame.origin[r]));
      const auto sum = hn::MulAdd(x, hn::Set(d, turn(r, 0)), hn::MulAdd(y, hn::Set(d, turn(r, 1)), rest));
      hn::StoreU(sum, d, &result.center[static_cast<std::size_t>(r)][i]);
    }
  }
}

/// Transforms axes to the world, and inverts them. \param turn includes the scale
void Whiten(const CandidateSet& from, const Eigen::Matrix3f& turn, LocalSplats& result) {
  const hn::CappedTag<float, kIndexWidth> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  for (std::size_t i = 0; i < from.size; i += hn::Lanes(d)) {
    V squared[3], axes[9];
    for (std::size_t k = 0; k < 3; ++k) {
      const V x = hn::LoadU(d, &from.rounded_axes[3 * k][i]),
              y = hn::LoadU(d, &from.rounded_axes[3 * k + 1][i]),
              z = hn::LoadU(d, &from.rounded_axes[3 * k + 2][i]);
      squared[k] = zero;
      for (std::size_t r = 0; r < 3; ++r) {
        const auto row = static_cast<Eigen::Index>(r);
        const V in_xy = hn::MulAdd(x, hn::Set(d, turn(row, 0)), hn::Mul(y, hn::Set(d, turn(row, 1))));
        axes[3 * k + r] = hn::MulAdd(z, hn::Set(d, turn(row, 2)), in_xy);
        squared[k] = hn::MulAdd(axes[3 * k + r], axes[3 * k + r], squared[k]);
      }
    }
    const V longest = hn::Sqrt(hn::Max(squared[0], hn::Max(squared[1], squared[2])));
    const V least = hn::Mul(longest, hn::Set(d, LocalSplats::kLeastThickness));
    hn::StoreU(longest, d, &result.radius[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const V length = hn::Sqrt(squared[k]);
      // The direction of an axis of zero length follows from the two others.
      const auto flat = hn::Eq(squared[k], zero);
      const V scale = hn::Div(hn::Set(d, 1.0F), hn::Mul(length, hn::Max(length, least)));
      for (std::size_t r = 0; r < 3; ++r)
        hn::StoreU(hn::IfThenElse(flat, zero, hn::Mul(axes[3 * k + r], scale)), d,
                   &result.whitening[3 * k + r][i]);
    }
  }
}

}  // namespace
}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate {
namespace {

HWY_EXPORT(Place);
HWY_EXPORT(Whiten);

using Eigen::Vector3f;

Vector3f row_of(const LocalSplats& splats, std::size_t k, std::size_t i) {
  return {splats.whitening[3 * k][i], splats.whitening[3 * k + 1][i], splats.whitening[3 * k + 2][i]};
}

/// Sets axes of splat i of zero length to a direction perpendicular to the others and to the least thickness.
void thicken(LocalSplats& splats, std::size_t i) {
  const float per_length = 1.0F / (LocalSplats::kLeastThickness * splats.radius[i]);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!row_of(splats, k, i).isZero(0.0F)) continue;
    const Vector3f b = row_of(splats, (k + 1) % 3, i), c = row_of(splats, (k + 2) % 3, i);
    const Vector3f longer = b.isZero(0.0F) ? c : b, across = b.cross(c);
    const Vector3f along = across.isZero(0.0F) ? longer.unitOrthogonal() : across.normalized();
    for (std::size_t r = 0; r < 3; ++r)
      splats.whitening[3 * k + r][i] = per_length * along[static_cast<Eigen::Index>(r)];
  }
}

void magnify(LocalSplats& splats, std::size_t i, float times) {
  for (auto& lane : splats.whitening) lane[i] /= times;
  splats.radius[i] *= times;
}

/// Returns false if a plane perpendicular to a semi-axis of the splat separates it from the solid.
/// \param from vector from the splat's centre to the solid's
bool slabs_meet(const LocalSplats& splats, std::size_t i, const Vector3f& from, const Eigen::Matrix3f& axes) {
  constexpr float kRounding = 1e-3F;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3f row = row_of(splats, k, i);
    if (std::abs(row.dot(from)) > (1.0F + kRounding) * (1.0F + (axes.transpose() * row).norm())) return false;
  }
  return true;
}

void copy_splat(const LocalSplats& from, std::size_t i, LocalSplats& to, std::size_t k) {
  for (std::size_t r = 0; r < 3; ++r) to.center[r][k] = from.center[r][i];
  for (std::size_t r = 0; r < 9; ++r) to.whitening[r][k] = from.whitening[r][i];
  to.radius[k] = from.radius[i];
  to.opacity[k] = from.opacity[i];
  to.id[k] = from.id[i];
}

}  // namespace

bool select_splats(const LocalSplats& splats, const Ellipsoid& solid, LocalSplats& result) {
  const std::size_t room = result.id.size() - kIndexWidth;
  const Eigen::Matrix3f axes = solid.axes.cast<float>();
  const double radius = solid.radius();
  std::size_t found = 0;
  result.size = 0;
  for (std::size_t i = 0; i < splats.size; ++i) {
    const Eigen::Vector3d from = solid.center - splats.position(i);
    const double reach = radius + static_cast<double>(splats.radius[i]);
    if (from.squaredNorm() > reach * reach || !slabs_meet(splats, i, from.cast<float>(), axes)) continue;
    if (found == room) return false;
    copy_splat(splats, i, result, found++);
  }
  result.size = found;
  return true;
}

LocalSplats::LocalSplats(std::size_t capacity) {
  const std::size_t room = capacity + kIndexWidth;
  for (auto& lane : center) lane.resize(room);
  for (auto& lane : whitening) lane.resize(room);
  radius.resize(room);
  opacity.resize(room);
  id.resize(room);
}

void fill_splats(const CandidateSet& from, const CapturedFrame& frame, float times, LocalSplats& result) {
  static_assert(LocalSplats::kCapacity >= CandidateSet::kCapacity);
  result.size = from.size;
  HWY_DYNAMIC_DISPATCH(Place)(from, frame, result);
  HWY_DYNAMIC_DISPATCH(Whiten)(from, frame.world_from_captured.cast<float>() / times, result);
  for (std::size_t i = 0; i < from.size; ++i) {
    bool is_flat = false;
    for (std::size_t k = 0; k < 3; ++k) is_flat |= row_of(result, k, i).isZero(0.0F);
    if (is_flat) thicken(result, i);
    if (from.label[i].extent < from.grain) magnify(result, i, from.grain / from.label[i].extent);
    result.opacity[i] = static_cast<float>(from.label[i].opacity);
    result.id[i] = from.label[i].id;
  }
}

}  // namespace palpate
#endif  // HWY_ONCE
