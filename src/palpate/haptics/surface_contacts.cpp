#include <palpate/haptics/surface_contacts.h>

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/haptics/surface_contacts.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/// Cosines where a contact begins to belong to a patch, and where it does wholly.
constexpr float kOtherPatch = 0.2F, kSamePatch = 0.6F;
/// Square of where the kernel (1 - r^2 / end)^3 ends, in deviations: its own is one.
constexpr float kKernelEnd = 10.0F;
/// A contact has its whole weight from this K_min on; below, it fades, so that none comes or goes with a
/// jump.
constexpr float kFullOverlap = 0.3F;

HWY_INLINE V set(float x) { return hn::Set(D(), x); }
HWY_INLINE V cube(V x) { return hn::Mul(x, hn::Mul(x, x)); }

/// 0 for x <= 0, 1 for x >= 1, smooth between.
HWY_INLINE V smooth_step(V x) {
  const V t = hn::Min(set(1.0F), hn::ZeroIfNegative(x));
  return hn::Mul(hn::Mul(t, t), hn::NegMulAdd(set(2.0F), t, set(3.0F)));
}

/// B of SurfaceMoments.
HWY_INLINE V belonging(V cosine) {
  return smooth_step(hn::Mul(hn::Sub(cosine, set(kOtherPatch)), set(1.0F / (kSamePatch - kOtherPatch))));
}

HWY_INLINE V kernel(V squared) {
  return cube(hn::ZeroIfNegative(hn::NegMulAdd(squared, set(1.0F / kKernelEnd), set(1.0F))));
}

HWY_INLINE V load(const SurfaceContacts& contacts, SurfaceContacts::Lane lane, std::size_t i) {
  return hn::LoadU(D(), contacts.lane(lane) + i);
}

/// Three lanes that follow each other.
struct Vec3 {
  V x, y, z;

  HWY_INLINE Vec3(V a, V b, V c) : x(a), y(b), z(c) {}
  HWY_INLINE Vec3(const SurfaceContacts& contacts, std::size_t first, std::size_t i)
      : x(load(contacts, SurfaceContacts::Lane(first), i)),
        y(load(contacts, SurfaceContacts::Lane(first + 1), i)),
        z(load(contacts, SurfaceContacts::Lane(first + 2), i)) {}

  HWY_INLINE void move_by(const Eigen::Vector3f& p) {
    x = hn::Sub(x, set(p.x()));
    y = hn::Sub(y, set(p.y()));
    z = hn::Sub(z, set(p.z()));
  }
  HWY_INLINE V dot(const Eigen::Vector3f& a) const {
    return hn::MulAdd(x, set(a.x()), hn::MulAdd(y, set(a.y()), hn::Mul(z, set(a.z()))));
  }
  HWY_INLINE V dot(const Vec3& a) const { return hn::MulAdd(x, a.x, hn::MulAdd(y, a.y, hn::Mul(z, a.z))); }
};

/// kWeight, kCoverage and kNarrowness from the lanes before them, and the point. \param shape of the enlarged
/// solid, and `thickness`, in the lanes' units
void Weigh(SurfaceContacts& contacts, const Eigen::Matrix3f& shape, float thickness) {
  const D d;
  const V one = set(1.0F), per_thickness = set(1.0F / (thickness * thickness));
  for (std::size_t i = 0; i < contacts.size(); i += hn::Lanes(d)) {
    const auto put = [&](SurfaceContacts::Lane lane, V v)
                         HWY_ATTR { hn::StoreU(v, d, contacts.lane(lane) + i); };
    const Vec3 n(contacts, SurfaceContacts::kNormalX, i), to_center(contacts, SurfaceContacts::kCenterX, i);
    V support = hn::Zero(d);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const V along = n.dot(Eigen::Vector3f(shape.col(k)));
      support = hn::MulAdd(along, along, support);
    }
    // From the definition of Contact::depth; squared, as its sign may be lost in rounding.
    const V h =
        hn::Sub(hn::Sub(load(contacts, SurfaceContacts::kDepth, i), hn::Sqrt(support)), n.dot(to_center));
    const V h_squared = hn::Mul(h, h);
    const V relative = hn::Mul(h_squared, per_thickness);
    const V trust = hn::Div(one, hn::MulAdd(relative, relative, one));
    const Vec3 p(contacts, SurfaceContacts::kPointX, i);
    const V inside =
        hn::Sub(hn::Abs(h),
                n.dot(Vec3{hn::Sub(p.x, to_center.x), hn::Sub(p.y, to_center.y), hn::Sub(p.z, to_center.z)}));
    const V outwards = hn::Mul(inside, hn::Div(h_squared, hn::Add(one, h_squared)));
    put(SurfaceContacts::kPointX, hn::MulAdd(n.x, outwards, p.x));
    put(SurfaceContacts::kPointY, hn::MulAdd(n.y, outwards, p.y));
    put(SurfaceContacts::kPointZ, hn::MulAdd(n.z, outwards, p.z));
    const V extent = load(contacts, SurfaceContacts::kExtent, i);
    const V s_squared = hn::Mul(set(0.5F), hn::ZeroIfNegative(hn::MulSub(extent, extent, h_squared)));
    const V narrowness = hn::Div(one, hn::Add(one, s_squared));
    const V fades =
        smooth_step(hn::Mul(load(contacts, SurfaceContacts::kOverlap, i), set(1.0F / kFullOverlap)));
    put(SurfaceContacts::kWeight,
        hn::Mul(hn::Mul(load(contacts, SurfaceContacts::kOpacity, i), fades), trust));
    put(SurfaceContacts::kCoverage, hn::Mul(trust, hn::Mul(s_squared, narrowness)));
    put(SurfaceContacts::kNarrowness, narrowness);
  }
}

SurfaceMoments Moments(SurfaceContacts& contacts, const SurfaceFrame& frame) {
  const D d;
  const V zero = hn::Zero(d);
  V w0 = zero, wx = zero, wy = zero, wr = zero, wxx = zero, wxy = zero, wxr = zero, wyy = zero, wyr = zero,
    wrr = zero, wz = zero, wxz = zero, wyz = zero, wrz = zero, heaviest = zero, layers = zero, opacity = zero;
  for (std::size_t i = 0; i < contacts.size(); i += hn::Lanes(d)) {
    const V same = belonging(Vec3(contacts, SurfaceContacts::kNormalX, i).dot(frame.n));
    float* explained = contacts.lane(SurfaceContacts::kExplained) + i;
    hn::StoreU(hn::Max(same, hn::LoadU(d, explained)), d, explained);

    Vec3 p(contacts, SurfaceContacts::kPointX, i);
    p.move_by(frame.origin);
    const V x = p.dot(frame.u), y = p.dot(frame.v), z = p.dot(frame.n);
    const V r = hn::MulAdd(x, x, hn::Mul(y, y));
    const V w = hn::Mul(hn::Mul(load(contacts, SurfaceContacts::kWeight, i), same), kernel(r));
    const V x_of_w = hn::Mul(w, x), y_of_w = hn::Mul(w, y), r_of_w = hn::Mul(w, r);
    w0 = hn::Add(w0, w);
    wx = hn::Add(wx, x_of_w);
    wy = hn::Add(wy, y_of_w);
    wr = hn::Add(wr, r_of_w);
    wxx = hn::MulAdd(x_of_w, x, wxx);
    wxy = hn::MulAdd(x_of_w, y, wxy);
    wxr = hn::MulAdd(x_of_w, r, wxr);
    wyy = hn::MulAdd(y_of_w, y, wyy);
    wyr = hn::MulAdd(y_of_w, r, wyr);
    wrr = hn::MulAdd(r_of_w, r, wrr);
    wz = hn::MulAdd(w, z, wz);
    wxz = hn::MulAdd(x_of_w, z, wxz);
    wyz = hn::MulAdd(y_of_w, z, wyz);
    wrz = hn::MulAdd(r_of_w, z, wrz);
    heaviest = hn::Max(heaviest, w);

    Vec3 c(contacts, SurfaceContacts::kCenterX, i);
    c.move_by(frame.origin);
    const V cx = c.dot(frame.u), cy = c.dot(frame.v);
    const V away =
        hn::Mul(hn::MulAdd(cx, cx, hn::Mul(cy, cy)), load(contacts, SurfaceContacts::kNarrowness, i));
    const V covers = hn::Mul(hn::Mul(load(contacts, SurfaceContacts::kCoverage, i), same), kernel(away));
    layers = hn::Add(layers, covers);
    opacity = hn::MulAdd(covers, load(contacts, SurfaceContacts::kOpacity, i), opacity);
  }
  const auto sum = [d](V v) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, v)); };
  SurfaceMoments result;
  result.normal_matrix = {sum(w0),  sum(wx),  sum(wy),  sum(wr),  sum(wxx),
                          sum(wxy), sum(wxr), sum(wyy), sum(wyr), sum(wrr)};
  result.right = {sum(wz), sum(wxz), sum(wyz), sum(wrz)};
  result.heaviest = hn::GetLane(hn::MaxOfLanes(d, heaviest));
  result.layers = sum(layers);
  result.opacity = sum(opacity);
  return result;
}

}  // namespace
}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate {
namespace {

HWY_EXPORT(Moments);
HWY_EXPORT(Weigh);

/// Of the widest vectors.
constexpr std::size_t kMostLanes = 16;

}  // namespace

SurfaceKernel SurfaceKernel::for_tool(double a_min, double detail, double extent) {
  return {detail, std::hypot(a_min, 2.0 * detail) - a_min, std::max(detail, extent)};
}

SurfaceContacts::SurfaceContacts(std::size_t capacity)
    : stride_(capacity + kMostLanes), values_(kLaneCount * stride_) {}

void SurfaceContacts::assign(std::span<const Contact> contacts, const Ellipsoid& larger,
                             const SurfaceKernel& kernel) {
  if (contacts.size() + kMostLanes > stride_) *this = SurfaceContacts(2 * contacts.size());
  size_ = contacts.size();
  const double unit = 1.0 / kernel.detail;
  float* const to = values_.data();
  for (std::size_t i = 0; i < size_; ++i) {
    const Contact& c = contacts[i];
    const auto put = [&](std::size_t lane, double value) {
      to[lane * stride_ + i] = static_cast<float>(value);
    };
    const auto put3 = [&](std::size_t lane, const Eigen::Vector3d& v) {
      put(lane, v.x());
      put(lane + 1, v.y());
      put(lane + 2, v.z());
    };
    put3(kPointX, unit * (c.point - larger.center));
    put3(kNormalX, c.normal);
    put3(kCenterX, unit * (c.center - larger.center));
    put(kOverlap, c.k_min);
    put(kOpacity, c.opacity);
    put(kDepth, unit * c.depth);
    put(kExtent, unit * c.extent);
  }
  for (std::size_t lane = 0; lane < kLaneCount; ++lane)
    std::fill_n(to + lane * stride_ + size_, kMostLanes, 0.0F);
  std::fill_n(to + kExplained * stride_, size_, 0.0F);
  HWY_DYNAMIC_DISPATCH(Weigh)
  (*this, (unit * larger.axes).cast<float>(), static_cast<float>(unit * kernel.thickness));
}

SurfaceMoments surface_moments(SurfaceContacts& contacts, const SurfaceFrame& frame) {
  return HWY_DYNAMIC_DISPATCH(Moments)(contacts, frame);
}

}  // namespace palpate
#endif  // HWY_ONCE
