#include <palpate/haptics/depth_view.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/haptics/depth_view.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#ifndef PALPATE_DEPTH_VIEW_JOB
#define PALPATE_DEPTH_VIEW_JOB
namespace palpate {

/// What the lanes are told of a view.
struct ViewJob {
  Eigen::Vector3f u, v, w;
  Eigen::Vector2f center;  ///< of the rays
  float reach;             ///< from there
  float start, detail;
  Eigen::Matrix3f larger;  ///< the inverse of the axes of what splats must reach into
};

/// The lanes' way to what DepthView keeps to itself.
struct DepthViewLanes {
  DepthView& view;

  static constexpr std::size_t kRegular = DepthView::kRegular, kRays = DepthView::kRays;
  /// Where a splat ends: exp(-m^2 / 2) is then less than what splatting draws.
  static constexpr float kEnd = 3.33F;
  static constexpr float kMostAlpha = 0.99F, kHalf = 0.5F;
  /// What the mean depth is the mean over.
  static constexpr float kBright = 0.75F, kDim = 0.25F;

  const std::array<LocalSplats::Array<float>, 3>& from() const { return view.from_; }
  std::size_t& size() { return view.size_; }
  float* x() { return view.x_.data(); }
  float* y() { return view.y_.data(); }
  float* depth() { return view.depth_.data(); }
  float* sum() { return view.sum_.data(); }
  float* share() { return view.share_.data(); }
  float* left() { return view.left_.data(); }
  float* clearance() { return view.clearance_.data(); }
  std::uint32_t* splat() { return view.splat_.data(); }
  float* t0() { return view.t0_.data(); }
  float* tx() { return view.tx_.data(); }
  float* ty() { return view.ty_.data(); }
  float* px() { return view.px_.data(); }
  float* py() { return view.py_.data(); }
  float* quu() { return view.quu_.data(); }
  float* quv() { return view.quv_.data(); }
  float* qvv() { return view.qvv_.data(); }
  float* log_alpha() { return view.log_alpha_.data(); }
  float* key() { return view.key_.data(); }
  float* below() { return view.below_.data(); }
  std::uint32_t* number() { return view.number_.data(); }
  const std::uint16_t* order() { return view.order_.data(); }
};

}  // namespace palpate
#endif  // PALPATE_DEPTH_VIEW_JOB

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;

HWY_INLINE V set(float x) { return hn::Set(D(), x); }

struct Vec3 {
  V x, y, z;

  HWY_INLINE V dot(const Vec3& b) const { return hn::MulAdd(x, b.x, hn::MulAdd(y, b.y, hn::Mul(z, b.z))); }
  HWY_INLINE V dot(const Eigen::Vector3f& b) const {
    return hn::MulAdd(x, set(b.x()), hn::MulAdd(y, set(b.y()), hn::Mul(z, set(b.z()))));
  }
  HWY_INLINE Vec3 cross(const Vec3& b) const {
    return {hn::NegMulAdd(z, b.y, hn::Mul(y, b.z)), hn::NegMulAdd(x, b.z, hn::Mul(z, b.x)),
            hn::NegMulAdd(y, b.x, hn::Mul(x, b.y))};
  }
};

HWY_INLINE Vec3 load3(const std::array<LocalSplats::Array<float>, 3>& lanes, std::size_t i) {
  return {hn::Load(D(), &lanes[0][i]), hn::Load(D(), &lanes[1][i]), hn::Load(D(), &lanes[2][i])};
}

/// The image of all splats that are in the window.
void Project(const LocalSplats& splats, const ViewJob& job, const Profile& solid, DepthViewLanes lanes) {
  const D d;
  const DU du;
  std::size_t size = 0;
  for (std::size_t i = 0; i < splats.size; i += hn::Lanes(d)) {
    const Vec3 from = load3(lanes.from(), i);
    const V px = from.dot(job.u), py = from.dot(job.v), pz = from.dot(job.w);
    const V dx = hn::Sub(px, set(job.center.x())), dy = hn::Sub(py, set(job.center.y()));
    const V away = hn::Sqrt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)));
    const V radius = hn::LoadU(d, &splats.radius[i]);
    const V extent = hn::Mul(radius, set(DepthViewLanes::kEnd));
    auto keep =
        hn::And(hn::Le(away, hn::Add(set(job.reach), extent)), hn::Ge(hn::Add(pz, extent), set(job.start)));
    keep = hn::And(keep, hn::FirstN(d, splats.size - i));
    if (hn::AllFalse(d, keep)) continue;
    // Rows of L times u, v, w and the way to the centre.
    const auto L = [&](std::size_t row) HWY_ATTR {
      return Vec3{hn::LoadU(d, &splats.whitening[3 * row][i]),
                  hn::LoadU(d, &splats.whitening[3 * row + 1][i]),
                  hn::LoadU(d, &splats.whitening[3 * row + 2][i])};
    };
    const Vec3 a = L(0), b = L(1), e = L(2);
    const Vec3 lw{a.dot(job.w), b.dot(job.w), e.dot(job.w)}, lu{a.dot(job.u), b.dot(job.u), e.dot(job.u)},
        lv{a.dot(job.v), b.dot(job.v), e.dot(job.v)};
    // The point of the ellipsoid on the way to the view's origin: if that is in the larger solid, so is some
    // of the ellipsoid. What is kept therefore depends on the pose alone, not on what else has been found
    // besides.
    const Vec3 lf{a.dot(from), b.dot(from), e.dot(from)};
    const V left = hn::ZeroIfNegative(
        hn::Sub(set(1.0F), hn::Div(set(1.0F), hn::Max(set(1e-12F), hn::Sqrt(lf.dot(lf))))));
    const Vec3 tip{from.dot(Eigen::Vector3f(job.larger.row(0))), from.dot(Eigen::Vector3f(job.larger.row(1))),
                   from.dot(Eigen::Vector3f(job.larger.row(2)))};
    keep = hn::And(keep, hn::Le(hn::Mul(hn::Mul(left, left), tip.dot(tip)), set(1.0F)));
    if (hn::AllFalse(d, keep)) continue;
    const V ww = lw.dot(lw), per_ww = hn::Div(set(1.0F), ww);
    // Depth of the nearest point of a ray, by the Gaussian's measure: linear in its place.
    const V tx = hn::Neg(hn::Mul(lw.dot(lu), per_ww)), ty = hn::Neg(hn::Mul(lw.dot(lv), per_ww));
    // Met where it begins, if it is thick: h^4 / (1 + h^4) of half its thickness earlier.
    const V half = hn::Sqrt(per_ww), h = hn::Min(set(1e6F), hn::Mul(half, set(1.0F / job.detail))),
            h2 = hn::Mul(h, h), h4 = hn::Mul(h2, h2);
    const V earlier = hn::Mul(half, hn::Div(h4, hn::Add(h4, set(1.0F))));
    const V at_center = hn::Sub(pz, earlier);
    const V t0 = hn::NegMulAdd(tx, px, hn::NegMulAdd(ty, py, at_center));
    // m^2 about the splat's own image: |(dx lu + dy lv) x lw|^2 / ww.
    const Vec3 cu = lu.cross(lw), cv = lv.cross(lw);
    const V quu = hn::Mul(cu.dot(cu), per_ww), quv = hn::Mul(cu.dot(cv), per_ww),
            qvv = hn::Mul(cv.dot(cv), per_ww);
    // Order: as deep as it is towards the window's centre, as far as it reaches.
    const V towards = hn::Min(set(1.0F), hn::Div(radius, hn::Max(away, set(1e-12F))));
    const V slope = hn::Neg(hn::Mul(towards, hn::MulAdd(tx, dx, hn::Mul(ty, dy))));
    const V key = hn::Add(at_center, hn::Max(hn::Neg(radius), hn::Min(radius, slope)));
    // How far it is from the solid, at its own place.
    const V facing =
        hn::NegMulAdd(hn::Mul(px, px), set(solid.aa),
                      hn::NegMulAdd(hn::Mul(hn::Add(px, px), py), set(solid.ab),
                                    hn::NegMulAdd(hn::Mul(py, py), set(solid.bb), set(solid.cc))));
    const V profile = hn::Mul(hn::Sub(hn::Sqrt(hn::ZeroIfNegative(facing)),
                                      hn::MulAdd(px, set(solid.d), hn::Mul(py, set(solid.e)))),
                              set(1.0F / solid.cc));
    const auto is_below =
        hn::And(hn::Gt(facing, set(Profile::kLeastFacing * solid.cc)), hn::Gt(pz, set(job.start)));
    const V below = hn::IfThenElse(is_below, hn::Sub(at_center, profile), set(DepthView::kNothing));
    const auto put = [&](V value, float* to) HWY_ATTR { hn::CompressStore(value, keep, d, to + size); };
    put(t0, lanes.t0());
    put(tx, lanes.tx());
    put(ty, lanes.ty());
    put(px, lanes.px());
    put(py, lanes.py());
    put(quu, lanes.quu());
    put(hn::Add(quv, quv), lanes.quv());
    put(qvv, lanes.qvv());
    put(hn::Log(d, hn::LoadU(d, &splats.opacity[i])), lanes.log_alpha());
    put(key, lanes.key());
    put(below, lanes.below());
    const auto numbers = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<std::uint32_t>(i)));
    size += hn::CompressStore(numbers, hn::RebindMask(du, keep), du, lanes.number() + size);
  }
  lanes.size() = size;
}

/// Follows all rays, front to back.
void Cast(const ViewJob& job, DepthViewLanes lanes) {
  const D d;
  const DU du;
  const std::size_t n = hn::Lanes(d);
  constexpr std::size_t rays = DepthViewLanes::kRays;
  for (std::size_t k = 0; k < rays; k += n) {
    hn::Store(set(1.0F), d, lanes.left() + k);
    hn::Store(set(DepthView::kNothing), d, lanes.depth() + k);
    hn::Store(hn::Zero(d), d, lanes.sum() + k);
    hn::Store(hn::Zero(d), d, lanes.share() + k);
  }
  constexpr std::size_t kLookEvery = 32;
  for (std::size_t s = 0; s < lanes.size(); ++s) {
    const std::size_t i = lanes.order()[s];
    if (s % kLookEvery == kLookEvery - 1) {
      V most = hn::Zero(d);
      for (std::size_t k = 0; k < rays; k += n) most = hn::Max(most, hn::Load(d, lanes.left() + k));
      if (hn::AllTrue(d, hn::Lt(most, set(DepthView::kDark)))) break;
    }
    const V t0 = set(lanes.t0()[i]), tx = set(lanes.tx()[i]), ty = set(lanes.ty()[i]),
            cx = set(lanes.px()[i]), cy = set(lanes.py()[i]), quu = set(lanes.quu()[i]),
            quv = set(lanes.quv()[i]), qvv = set(lanes.qvv()[i]), log_alpha = set(lanes.log_alpha()[i]);
    const auto number = hn::Set(du, lanes.number()[i]);
    for (std::size_t k = 0; k < rays; k += n) {
      const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k);
      const V dx = hn::Sub(x, cx), dy = hn::Sub(y, cy);
      const V m2 = hn::MulAdd(dx, hn::MulAdd(dx, quu, hn::Mul(dy, quv)), hn::Mul(hn::Mul(dy, dy), qvv));
      const V t = hn::MulAdd(x, tx, hn::MulAdd(y, ty, t0));
      const auto drawn =
          hn::And(hn::Lt(m2, set(DepthViewLanes::kEnd * DepthViewLanes::kEnd)), hn::Gt(t, set(job.start)));
      if (hn::AllFalse(d, drawn)) continue;
      const V alpha =
          hn::Min(set(DepthViewLanes::kMostAlpha), hn::Exp(d, hn::MulAdd(m2, set(-0.5F), log_alpha)));
      const V before = hn::Load(d, lanes.left() + k);
      const V after = hn::IfThenElse(drawn, hn::NegMulAdd(before, alpha, before), before);
      hn::Store(after, d, lanes.left() + k);
      const V fall = hn::ZeroIfNegative(
          hn::Sub(hn::Min(before, set(DepthViewLanes::kBright)), hn::Max(after, set(DepthViewLanes::kDim))));
      const V share = hn::Mul(fall, set(1.0F / (DepthViewLanes::kBright - DepthViewLanes::kDim)));
      hn::Store(hn::Add(share, hn::Load(d, lanes.share() + k)), d, lanes.share() + k);
      hn::Store(hn::MulAdd(share, t, hn::Load(d, lanes.sum() + k)), d, lanes.sum() + k);
      const auto seen =
          hn::And(hn::Ge(before, set(DepthViewLanes::kHalf)), hn::Lt(after, set(DepthViewLanes::kHalf)));
      if (hn::AllFalse(d, seen)) continue;
      hn::Store(hn::IfThenElse(seen, t, hn::Load(d, lanes.depth() + k)), d, lanes.depth() + k);
      hn::Store(hn::IfThenElse(hn::RebindMask(du, seen), number, hn::Load(du, lanes.splat() + k)), du,
                lanes.splat() + k);
    }
  }
}

void Clear(const Profile& solid, DepthViewLanes lanes) {
  const D d;
  for (std::size_t k = 0; k < DepthViewLanes::kRays; k += hn::Lanes(d)) {
    const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k),
            z = hn::Load(d, lanes.depth() + k);
    const V facing = hn::NegMulAdd(hn::Mul(x, x), set(solid.aa),
                                   hn::NegMulAdd(hn::Mul(hn::Add(x, x), y), set(solid.ab),
                                                 hn::NegMulAdd(hn::Mul(y, y), set(solid.bb), set(solid.cc))));
    const V profile = hn::Mul(
        hn::Sub(hn::Sqrt(hn::ZeroIfNegative(facing)), hn::MulAdd(x, set(solid.d), hn::Mul(y, set(solid.e)))),
        set(1.0F / solid.cc));
    const auto counts =
        hn::And(hn::Gt(facing, set(Profile::kLeastFacing * solid.cc)), hn::Lt(z, set(DepthView::kNothing)));
    hn::Store(hn::IfThenElse(counts, hn::Sub(z, profile), set(DepthView::kNothing)), d,
              lanes.clearance() + k);
  }
}

DepthMoments Moments(DepthViewLanes lanes, const DepthKernel& kernel) {
  const D d;
  const V zero = hn::Zero(d), one = set(1.0F);
  const auto unit = static_cast<float>(1.0 / kernel.unit);
  const float per_end = 1.0F / (kernel.end * kernel.end);
  V w0 = zero, wx = zero, wy = zero, wr = zero, wxx = zero, wxy = zero, wxr = zero, wyy = zero, wyr = zero,
    wrr = zero, wz = zero, wxz = zero, wyz = zero, wrz = zero, ws = zero, all = zero, through = zero;
  for (std::size_t k = 0; k < DepthViewLanes::kRegular; k += hn::Lanes(d)) {
    const V x =
        hn::Mul(set(unit), hn::Sub(hn::Load(d, lanes.x() + k), set(static_cast<float>(kernel.center.x()))));
    const V y =
        hn::Mul(set(unit), hn::Sub(hn::Load(d, lanes.y() + k), set(static_cast<float>(kernel.center.y()))));
    const V share = hn::Load(d, lanes.share() + k);
    const auto hit = hn::Gt(share, zero);
    const V depth = hn::Div(hn::Load(d, lanes.sum() + k), hn::Max(share, set(1e-12F)));
    const V z =
        hn::IfThenElse(hit, hn::Mul(set(unit), hn::Sub(depth, set(static_cast<float>(kernel.level)))), zero);
    const V r = hn::MulAdd(x, x, hn::Mul(y, y));
    const V g = hn::ZeroIfNegative(hn::NegMulAdd(r, set(per_end), one));
    const V aim = hn::Mul(g, hn::Mul(g, g));
    const V fit =
        hn::MulAdd(set(kernel.fit[1]), x,
                   hn::MulAdd(set(kernel.fit[2]), y, hn::MulAdd(set(kernel.fit[3]), r, set(kernel.fit[0]))));
    const V off = hn::Mul(hn::Sub(z, fit), set(1.0F / kernel.spread)), off2 = hn::Mul(off, off);
    const V w = hn::IfThenElseZero(hit, hn::Div(hn::Mul(share, aim), hn::Add(one, off2)));
    const V x_of_w = hn::Mul(w, x), y_of_w = hn::Mul(w, y), r_of_w = hn::Mul(w, r);
    all = hn::Add(all, aim);
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
    ws = hn::MulAdd(w, off2, ws);
    through = hn::MulAdd(w, hn::Load(d, lanes.left() + k), through);
  }
  const auto sum = [d](V v) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, v)); };
  DepthMoments result;
  result.normal_matrix = {sum(w0),  sum(wx),  sum(wy),  sum(wr),  sum(wxx),
                          sum(wxy), sum(wxr), sum(wyy), sum(wyr), sum(wrr)};
  result.right = {sum(wz), sum(wxz), sum(wyz), sum(wrz)};
  result.hit = sum(w0);
  result.residual = sum(ws) * kernel.spread * kernel.spread;
  result.aimed = sum(all);
  result.seen_through = sum(through);
  return result;
}

}  // namespace
}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate {
namespace {

HWY_EXPORT(Project);
HWY_EXPORT(Cast);
HWY_EXPORT(Clear);
HWY_EXPORT(Moments);

using Eigen::Vector3d;

/// A sunflower: points of equal share of the unit disc, from the middle outwards.
std::array<Eigen::Vector2d, DepthView::kRegular> make_sunflower() {
  constexpr double kGoldenAngle = 2.39996322972865332;
  std::array<Eigen::Vector2d, DepthView::kRegular> points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double r = std::sqrt((static_cast<double>(k) + 0.5) / static_cast<double>(points.size()));
    const double angle = static_cast<double>(k) * kGoldenAngle;
    points[k] = {r * std::cos(angle), r * std::sin(angle)};
  }
  return points;
}

const std::array<Eigen::Vector2d, DepthView::kRegular> kSunflower = make_sunflower();

}  // namespace

ViewFrame ViewFrame::along(const Vector3d& w, const Vector3d& origin, const Vector3d& u) {
  const Vector3d aside = u - u.dot(w) * w;
  const double length = aside.norm();
  const Vector3d axis = length > 1e-3 ? Vector3d(aside / length) : w.unitOrthogonal();
  return {origin, axis, w.cross(axis), w};
}

Profile::Profile(const Ellipsoid& solid, const ViewFrame& view) {
  // Axes are orthogonal: the inverse has their rows over their squared lengths.
  Eigen::Matrix3d B = solid.axes.transpose();
  for (Eigen::Index k = 0; k < 3; ++k) B.row(k) /= solid.axes.col(k).squaredNorm();
  const Vector3d u = B * view.u, v = B * view.v, c = B * view.w, a = u.cross(c), b = v.cross(c);
  aa = static_cast<float>(a.squaredNorm());
  ab = static_cast<float>(a.dot(b));
  bb = static_cast<float>(b.squaredNorm());
  cc = static_cast<float>(c.squaredNorm());
  d = static_cast<float>(u.dot(c));
  e = static_cast<float>(v.dot(c));
}

bool Profile::below(float x, float y) const {
  return cc - x * x * aa - 2.0F * x * y * ab - y * y * bb > kLeastFacing * cc;
}

float Profile::depth(float x, float y) const {
  const float facing = cc - x * x * aa - 2.0F * x * y * ab - y * y * bb;
  return (std::sqrt(std::max(0.0F, facing)) - x * d - y * e) / cc;
}

RayPattern RayPattern::over_ellipse(const Eigen::Matrix2d& shape) {
  RayPattern pattern;
  pattern.reach = shape.norm();  // not less than the largest singular value
  pattern.size = kMost;
  for (std::size_t k = 0; k < kMost; ++k) pattern.places[k] = (shape * kSunflower[k]).cast<float>();
  return pattern;
}

RayPattern RayPattern::on_lattice(const Eigen::Vector2d& center, double radius, Eigen::Vector2d& anchor) {
  // Of the radius: pi / (sqrt(3) / 2 0.26^2) = 54 points on average, and never as many as there is room for.
  constexpr double kSpacing = 0.26;
  const double s = kSpacing * radius, row = 0.5 * std::sqrt(3.0) * s;
  // The lattice point nearest to the centre, but for a cell.
  const Eigen::Vector2d away = center - anchor;
  const double j = std::round(away.y() / row), i = std::round((away.x() - 0.5 * s * j) / s);
  anchor += Eigen::Vector2d(s * (i + 0.5 * j), row * j);
  RayPattern pattern;
  pattern.center = center;
  pattern.reach = radius;
  constexpr int kRows = 6;  // more than radius / row, and half a cell
  for (int b = -kRows; b <= kRows; ++b) {
    for (int a = -kRows - (b - 1) / 2; a <= kRows - (b - 1) / 2 && pattern.size < kMost; ++a) {
      const Eigen::Vector2d place = anchor + Eigen::Vector2d(s * (a + 0.5 * b), row * b);
      if ((place - center).squaredNorm() < radius * radius)
        pattern.places[pattern.size++] = place.cast<float>();
    }
  }
  return pattern;
}

void DepthView::look(const LocalSplats& splats, const ViewFrame& view, const Profile& profile,
                     const Ellipsoid& larger, const RayPattern& pattern, double start, double detail) {
  ViewJob job{view.u.cast<float>(),
              view.v.cast<float>(),
              view.w.cast<float>(),
              pattern.center.cast<float>(),
              static_cast<float>(pattern.reach),
              static_cast<float>(start),
              static_cast<float>(detail),
              {}};
  for (Eigen::Index k = 0; k < 3; ++k)
    job.larger.row(k) = (larger.axes.col(k) / larger.axes.col(k).squaredNorm()).cast<float>().transpose();
  constexpr float kFarAway = 1e6F;  // where no ray meets anything
  for (std::size_t k = 0; k < kRegular; ++k) {
    x_[k] = k < pattern.size ? pattern.places[k].x() : kFarAway;
    y_[k] = k < pattern.size ? pattern.places[k].y() : kFarAway;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double from = view.origin[static_cast<Eigen::Index>(k)];
    for (std::size_t i = 0; i < splats.size; ++i)
      from_[k][i] = static_cast<float>(splats.center[k][i] - from);
  }
  const DepthViewLanes lanes{*this};
  HWY_DYNAMIC_DISPATCH(Project)(splats, job, profile, lanes);
  aim_extra_rays(pattern.center);
  order();
  HWY_DYNAMIC_DISPATCH(Cast)(job, lanes);
  HWY_DYNAMIC_DISPATCH(Clear)(profile, lanes);
}

/// In the middle, and through what is nearest below the solid.
void DepthView::aim_extra_rays(const Eigen::Vector2d& center) {
  constexpr std::size_t kSought = kExtra - 1;
  std::array<std::uint16_t, kSought> found;
  std::size_t count = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    const float below = below_[i];
    if (!(below < kNothing) || (count == kSought && below >= below_[found[kSought - 1]])) continue;
    std::size_t at = count < kSought ? count++ : kSought - 1;
    for (; at > 0 && below_[found[at - 1]] > below; --at) found[at] = found[at - 1];
    found[at] = static_cast<std::uint16_t>(i);
  }
  for (std::size_t k = 0; k < kExtra; ++k) {
    const bool aimed = k > 0 && k <= count;
    x_[kRegular + k] = aimed ? px_[found[k - 1]] : static_cast<float>(center.x());
    y_[kRegular + k] = aimed ? py_[found[k - 1]] : static_cast<float>(center.y());
  }
}

/// By depth, to a part of the whole range that is finer than what is felt.
void DepthView::order() {
  constexpr std::size_t kBins = 512;
  std::array<std::uint16_t, kBins + 1> first{};
  float least = kNothing, most = -kNothing;
  for (std::size_t i = 0; i < size_; ++i) {
    least = std::min(least, key_[i]);
    most = std::max(most, key_[i]);
  }
  const float per_bin = most > least ? (static_cast<float>(kBins) - 0.5F) / (most - least) : 0.0F;
  const auto bin_of = [&](std::size_t i) {
    const float bin = (key_[i] - least) * per_bin;
    return bin > 0.0F ? static_cast<std::size_t>(std::min(bin, static_cast<float>(kBins - 1))) : 0;
  };
  for (std::size_t i = 0; i < size_; ++i) ++first[bin_of(i) + 1];
  for (std::size_t b = 0; b < kBins; ++b) first[b + 1] = static_cast<std::uint16_t>(first[b + 1] + first[b]);
  for (std::size_t i = 0; i < size_; ++i) order_[first[bin_of(i)]++] = static_cast<std::uint16_t>(i);
}

std::size_t DepthView::nearest() const {
  std::size_t best = kRays;
  for (std::size_t k = 0; k < kRays; ++k) {
    if (clearance_[k] < kNothing && (best == kRays || clearance_[k] < clearance_[best])) best = k;
  }
  return best;
}

DepthMoments DepthView::moments(const DepthKernel& kernel) const {
  return HWY_DYNAMIC_DISPATCH(Moments)(DepthViewLanes{const_cast<DepthView&>(*this)}, kernel);
}

}  // namespace palpate
#endif  // HWY_ONCE
