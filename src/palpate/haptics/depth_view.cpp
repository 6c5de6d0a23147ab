#include <palpate/haptics/depth_view.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/instruction_sets.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/haptics/depth_view.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#ifndef PALPATE_DEPTH_VIEW_JOB
#define PALPATE_DEPTH_VIEW_JOB
namespace palpate {

/// Parameters of a view, for the SIMD code.
struct ViewJob {
  Eigen::Vector3f u, v, w;
  Eigen::Vector2f center;  ///< of the rays
  float reach;             ///< largest distance of a ray from it
  float since, start;      ///< depths: from which rays are attenuated, and of the first possible hit
  float known;             ///< depth at which rays begin at the latest, even if behind the solid
  float end;               ///< largest depth of the larger solid
  Eigen::Vector2f anchor;  ///< see RayPattern
  Eigen::Matrix2f to_cell;
};

/// Access of the SIMD code to the private members of DepthView.
struct DepthViewLanes {
  DepthView& view;

  using NearPlace = DepthView::NearPlace;
  static constexpr std::size_t kRegular = DepthView::kRegular, kRays = DepthView::kRays;
  /// Mahalanobis distance at which a splat ends.
  static constexpr float kEnd = CandidateCache::kDrawn;
  static constexpr std::uint32_t kBins = DepthView::kBins;
  static constexpr float kMostAlpha = 0.99F;
  /// Transmittances between which the mean depth is taken.
  static constexpr float kBright = 0.75F, kDim = 0.25F;

  const auto& from() const { return view.from_; }
  std::size_t& size() { return view.size_; }
  float* x() { return view.x_.data(); }
  float* y() { return view.y_.data(); }
  float* depth() { return view.depth_.data(); }
  float* sum() { return view.sum_.data(); }
  float* share() { return view.share_.data(); }
  float* left() { return view.left_.data(); }
  float* near() { return view.near_.data(); }
  float* far() { return view.far_.data(); }
  float* begin() { return view.begin_.data(); }
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
  float* regular() { return view.regular_.data(); }
  float* half_width() { return view.half_width_.data(); }
  float* half_height() { return view.half_height_.data(); }
  std::uint32_t* number() { return view.number_.data(); }
  std::uint32_t* chosen() { return view.chosen_.data(); }
  std::uint32_t* chosen_blocks() { return view.chosen_blocks_.data(); }
  std::uint32_t* bin() { return view.bin_.data(); }
  std::span<const SplatImage> images() const { return {view.images_.data(), view.image_count_}; }
  const DepthView::RayBlocks& blocks() const { return view.blocks_; }
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

template <class Lanes>
HWY_INLINE Vec3 load3(const Lanes& lanes, std::size_t i) {
  return {hn::Load(D(), &lanes[0][i]), hn::Load(D(), &lanes[1][i]), hn::Load(D(), &lanes[2][i])};
}

/// Chord of an ellipsoid along a ray, one per lane; see Profile.
struct Chord {
  V facing, middle, per_cc;

  HWY_INLINE Chord(const Profile& solid, V x, V y) {
    facing = hn::NegMulAdd(hn::Mul(x, x), set(solid.aa),
                           hn::NegMulAdd(hn::Mul(hn::Add(x, x), y), set(solid.ab),
                                         hn::NegMulAdd(hn::Mul(y, y), set(solid.bb), set(solid.cc))));
    middle = hn::Neg(hn::MulAdd(x, set(solid.d), hn::Mul(y, set(solid.e))));
    per_cc = set(1.0F / solid.cc);
  }
  HWY_INLINE V half() const { return hn::Sqrt(hn::ZeroIfNegative(facing)); }
  HWY_INLINE V near() const { return hn::Mul(hn::Sub(middle, half()), per_cc); }
  HWY_INLINE V far() const { return hn::Mul(hn::Add(middle, half()), per_cc); }
};

/// Splats, one per lane or the same in all; see SplatImage.
struct Drawn {
  V t0, tx, ty, px, py, quu, quv, qvv, log_alpha;

  static HWY_INLINE Drawn load(DepthViewLanes& lanes, std::size_t i) {
    const auto at = [i](const float* from) HWY_ATTR { return hn::LoadU(D(), from + i); };
    return {at(lanes.t0()),  at(lanes.tx()),  at(lanes.ty()),  at(lanes.px()),       at(lanes.py()),
            at(lanes.quu()), at(lanes.quv()), at(lanes.qvv()), at(lanes.log_alpha())};
  }
  static HWY_INLINE Drawn in_all_lanes(const SplatImage& image) {
    return {set(image.t0),  set(image.tx),  set(image.ty),  set(image.px),       set(image.py),
            set(image.quu), set(image.quv), set(image.qvv), set(image.log_alpha)};
  }

  HWY_INLINE V m2(V x, V y) const {
    const V dx = hn::Sub(x, px), dy = hn::Sub(y, py);
    return hn::MulAdd(dx, hn::MulAdd(dx, quu, hn::Mul(dy, quv)), hn::Mul(hn::Mul(dy, dy), qvv));
  }
  HWY_INLINE V depth(V x, V y) const { return hn::MulAdd(x, tx, hn::MulAdd(y, ty, t0)); }
  /// \param m2 is clamped at the end of the splat: exponentials that underflow are slow.
  HWY_INLINE V alpha(V m2) const {
    const D d;
    const V drawn = hn::Min(m2, set(DepthViewLanes::kEnd * DepthViewLanes::kEnd));
    return hn::Min(set(DepthViewLanes::kMostAlpha), hn::Exp(d, hn::MulAdd(drawn, set(-0.5F), log_alpha)));
  }
};

/// Projects the splats and keeps those in the window.
void Project(const LocalSplats& splats, const ViewJob& job, DepthViewLanes lanes) {
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
    auto keep = hn::And(
        hn::Le(away, hn::Add(set(job.reach), extent)),
        hn::And(hn::Ge(hn::Add(pz, extent), set(job.since)), hn::Le(hn::Sub(pz, extent), set(job.end))));
    keep = hn::And(keep, hn::FirstN(d, splats.size - i));
    if (hn::AllFalse(d, keep)) continue;
    // Rows of L times u, v, w and the vector to the centre.
    const auto L = [&](std::size_t row) HWY_ATTR {
      return Vec3{hn::LoadU(d, &splats.whitening[3 * row][i]),
                  hn::LoadU(d, &splats.whitening[3 * row + 1][i]),
                  hn::LoadU(d, &splats.whitening[3 * row + 2][i])};
    };
    const Vec3 a = L(0), b = L(1), e = L(2);
    const Vec3 lw{a.dot(job.w), b.dot(job.w), e.dot(job.w)}, lu{a.dot(job.u), b.dot(job.u), e.dot(job.u)},
        lv{a.dot(job.v), b.dot(job.v), e.dot(job.v)};
    const V ww = lw.dot(lw), per_ww = hn::Div(set(1.0F), ww);
    // Depth at which a ray has the least Mahalanobis distance: linear in the position of the ray.
    const V tx = hn::Neg(hn::Mul(lw.dot(lu), per_ww)), ty = hn::Neg(hn::Mul(lw.dot(lv), per_ww));
    const V t0 = hn::NegMulAdd(tx, px, hn::NegMulAdd(ty, py, pz));
    // m^2 relative to the projected centre: |(dx lu + dy lv) x lw|^2 / ww.
    const Vec3 cu = lu.cross(lw), cv = lv.cross(lw);
    const V quu = hn::Mul(cu.dot(cu), per_ww), quv = hn::Mul(cu.dot(cv), per_ww),
            qvv = hn::Mul(cv.dot(cv), per_ww);
    // It is drawn in a rectangle about that, of half sides 3 / sqrt(det Q) times sqrt(qvv) and sqrt(quu).
    const V det = hn::Max(hn::NegMulAdd(quv, quv, hn::Mul(quu, qvv)), set(1e-30F));
    const V unit = hn::Div(set(DepthViewLanes::kEnd), hn::Sqrt(det)), reach = set(job.reach);
    keep = hn::And(keep, hn::Le(hn::Abs(dx), hn::MulAdd(unit, hn::Sqrt(qvv), reach)));
    keep = hn::And(keep, hn::Le(hn::Abs(dy), hn::MulAdd(unit, hn::Sqrt(quu), reach)));
    // Rays meet it at most so much before or behind its centre.
    const V tilt =
        hn::MulAdd(tx, hn::NegMulAdd(hn::Add(ty, ty), quv, hn::Mul(tx, qvv)), hn::Mul(hn::Mul(ty, ty), quu));
    const V thick = hn::Mul(unit, hn::Sqrt(hn::ZeroIfNegative(tilt)));
    keep = hn::And(
        keep, hn::And(hn::Ge(hn::Add(pz, thick), set(job.since)), hn::Le(hn::Sub(pz, thick), set(job.end))));
    // Whether a lattice point may be in that rectangle: a splat small compared with a cell may lie between
    // lattice points.
    const auto& T = job.to_cell;
    const V ax = hn::Sub(px, set(job.anchor.x())), ay = hn::Sub(py, set(job.anchor.y()));
    const V cx = hn::MulAdd(ax, set(T(0, 0)), hn::Mul(ay, set(T(0, 1)))),
            cy = hn::MulAdd(ax, set(T(1, 0)), hn::Mul(ay, set(T(1, 1))));
    const auto width = [&](float p, float q) HWY_ATTR {
      const V squared =
          hn::MulAdd(set(p * p), qvv, hn::NegMulAdd(set(2.0F * p * q), quv, hn::Mul(set(q * q), quu)));
      return hn::Mul(unit, hn::Sqrt(hn::ZeroIfNegative(squared)));
    };
    const V wide = width(T(0, 0), T(0, 1)), high = width(T(1, 0), T(1, 1));
    constexpr float kRow = 0.8660254F;
    const V row = hn::Round(hn::Mul(cy, set(1.0F / kRow))), along = hn::NegMulAdd(set(0.5F), row, cx);
    const auto meets_row = hn::Le(hn::Abs(hn::NegMulAdd(row, set(kRow), cy)), high);
    const auto meets_point = hn::Le(hn::Abs(hn::Sub(along, hn::Round(along))), wide);
    const auto regular = hn::Or(hn::Ge(high, set(0.5F * kRow)), hn::And(meets_row, meets_point));
    // Sort key: depth at the point of the splat, within its extent, nearest to the window's centre.
    const V towards = hn::Min(set(1.0F), hn::Div(radius, hn::Max(away, set(1e-12F))));
    const V slope = hn::Neg(hn::Mul(towards, hn::MulAdd(tx, dx, hn::Mul(ty, dy))));
    const V key = hn::Add(pz, hn::Max(hn::Neg(radius), hn::Min(radius, slope)));
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
    put(hn::IfThenElse(regular, set(1.0F), hn::Zero(d)), lanes.regular());
    put(hn::Mul(unit, hn::Sqrt(qvv)), lanes.half_width());
    put(hn::Mul(unit, hn::Sqrt(quu)), lanes.half_height());
    const auto numbers = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<std::uint32_t>(i)));
    size += hn::CompressStore(numbers, hn::RebindMask(du, keep), du, lanes.number() + size);
  }
  lanes.size() = size;
}

/// Places of splats, one per lane.
struct Places {
  V x, y;
  V clearance;  ///< from the solid; DepthView::kNothing if a place is not below it

  /// Replaces those that others are nearer than, by `gain` at least.
  HWY_INLINE void improve(const Places& other, V gain) {
    const auto nearer = hn::Lt(hn::Add(other.clearance, gain), clearance);
    x = hn::IfThenElse(nearer, other.x, x);
    y = hn::IfThenElse(nearer, other.y, y);
    clearance = hn::IfThenElse(nearer, other.clearance, clearance);
  }
};

/// The way from the centre of a splat to the place nearest to the solid where it hides half of the light by
/// itself, to first order: along -Q^-1 g, with Q of m^2 and g the gradient of the clearance.
struct Approach {
  V x, y;
  V gain;  ///< of clearance, at most: that is convex

  HWY_INLINE Approach(const Drawn& splat, const Profile& solid, V facing) {
    constexpr float kLogHalf = -0.6931472F;
    constexpr float kMostM2 = 1.0F;  // beyond the ellipsoid, nothing is a contact
    const V steep = hn::Div(set(1.0F / solid.cc), hn::Sqrt(facing));
    const auto slope = [&](V along, float a, float b, float linear) HWY_ATTR {
      const V curved = hn::MulAdd(splat.px, set(a), hn::Mul(splat.py, set(b)));
      return hn::Add(hn::MulAdd(curved, steep, along), set(linear / solid.cc));
    };
    const V gx = slope(splat.tx, solid.aa, solid.ab, solid.d),
            gy = slope(splat.ty, solid.ab, solid.bb, solid.e);
    const V half_quv = hn::Mul(set(0.5F), splat.quv);
    const V to_x = hn::NegMulAdd(half_quv, gy, hn::Mul(splat.qvv, gx));  // det Q times Q^-1 g
    const V to_y = hn::NegMulAdd(half_quv, gx, hn::Mul(splat.quu, gy));
    const V det = hn::Max(hn::NegMulAdd(half_quv, half_quv, hn::Mul(splat.quu, splat.qvv)), set(1e-30F));
    const V along = hn::Max(hn::MulAdd(gx, to_x, hn::Mul(gy, to_y)), set(1e-30F));
    const V log_surplus = hn::Sub(splat.log_alpha, set(kLogHalf));
    const V m2 = hn::Min(set(kMostM2), hn::ZeroIfNegative(hn::Add(log_surplus, log_surplus)));
    const V way = hn::Neg(hn::Sqrt(hn::Div(m2, hn::Mul(along, det))));
    x = hn::Mul(way, to_x);
    y = hn::Mul(way, to_y);
    gain = hn::Sqrt(hn::Div(hn::Mul(m2, along), det));
  }
};

/// Finds the splats nearest below the solid, nearest first, and where they are nearest. Most are discs and
/// needles, and a tool meets the rim of a lone one long before its centre. \returns their number.
std::size_t FindNearest(const ViewJob& job, const Profile& solid, const Profile& larger, DepthViewLanes lanes,
                        std::span<DepthViewLanes::NearPlace> found) {
  // Nearer to the silhouette than 10 degrees, a floor that the tool slides along is not in its way, and the
  // gradient is that at 18.
  constexpr float kFlank = 0.03F, kSteepest = 0.1F;
  // Only what is large for the tool: of many small ones in a surface, the nearest rims would be early.
  const V least_gain = set(0.1F / std::sqrt(solid.cc));
  const D d;
  const auto place = [&](const Drawn& splat, V x, V y, const Chord& chord, float flank) HWY_ATTR {
    const V depth = splat.depth(x, y);
    const auto is_below =
        hn::And(hn::Gt(chord.facing, set(flank * solid.cc)),
                hn::And(hn::Gt(depth, set(job.start)), hn::Lt(depth, Chord(larger, x, y).far())));
    return Places{x, y, hn::IfThenElse(is_below, hn::Sub(depth, chord.far()), set(DepthView::kNothing))};
  };
  std::size_t count = 0;
  float most = DepthView::kNothing;
  for (std::size_t first = 0; first < lanes.size(); first += hn::Lanes(d)) {
    const Drawn splat = Drawn::load(lanes, first);
    const Chord chord(solid, splat.px, splat.py);
    Places nearest = place(splat, splat.px, splat.py, chord, Profile::kLeastFacing);
    const V least_facing = set(kSteepest * solid.cc);
    const Approach approach(splat, solid, hn::Max(chord.facing, least_facing));
    const V least = hn::Sub(hn::Sub(splat.depth(splat.px, splat.py), chord.far()), approach.gain);
    const auto may_gain = hn::And(hn::Gt(approach.gain, least_gain),
                                  hn::Or(hn::Lt(chord.facing, least_facing), hn::Lt(least, set(most))));
    if (!hn::AllFalse(d, may_gain)) {
      const V gain = hn::IfThenElse(may_gain, least_gain, set(DepthView::kNothing));
      // The solid is curved: half of the way may be nearer.
      for (const float part : {0.5F, 1.0F}) {
        const V x = hn::MulAdd(set(part), approach.x, splat.px),
                y = hn::MulAdd(set(part), approach.y, splat.py);
        nearest.improve(place(splat, x, y, Chord(solid, x, y), kFlank), gain);
      }
    }
    if (hn::AllFalse(d, hn::Lt(nearest.clearance, set(most)))) continue;
    HWY_ALIGN std::array<float, hn::MaxLanes(D())> x, y, clearance;
    hn::Store(nearest.x, d, x.data());
    hn::Store(nearest.y, d, y.data());
    hn::Store(nearest.clearance, d, clearance.data());
    const std::size_t end = std::min(hn::Lanes(d), lanes.size() - first);
    for (std::size_t i = 0; i < end; ++i) {
      if (!(clearance[i] < most)) continue;
      std::size_t at = count < found.size() ? count++ : count - 1;
      for (; at > 0 && found[at - 1].clearance > clearance[i]; --at) found[at] = found[at - 1];
      found[at] = {x[i], y[i], clearance[i]};
      if (count == found.size()) most = found[count - 1].clearance;
    }
  }
  return count;
}

/// Selects the splats of the window that rays may meet, with their blocks of rays and their depth bins.
/// \returns their number.
std::size_t Choose(const ViewJob& job, DepthViewLanes lanes) {
  constexpr std::uint32_t kExtraBlocks = ~0U << (DepthView::kRegular / DepthView::kBlock);
  const D d;
  const DU du;
  const hn::RebindToSigned<D> di;
  const DepthView::RayBlocks& blocks = lanes.blocks();
  const float range = job.end - job.since;
  const V per_bin = set(range > 0.0F ? static_cast<float>(DepthViewLanes::kBins) / range : 0.0F);
  std::size_t count = 0;
  for (std::size_t i = 0; i < lanes.size(); i += hn::Lanes(d)) {
    const V px = hn::LoadU(d, lanes.px() + i), wide = hn::LoadU(d, lanes.half_width() + i);
    const V py = hn::LoadU(d, lanes.py() + i), high = hn::LoadU(d, lanes.half_height() + i);
    const V low_x = hn::Sub(px, wide), high_x = hn::Add(px, wide), low_y = hn::Sub(py, high),
            high_y = hn::Add(py, high);
    auto near = hn::Zero(du);
    for (std::size_t b = 0; b < DepthView::kBlocks; ++b) {
      const auto in_x = hn::And(hn::Le(set(blocks.low_x[b]), high_x), hn::Ge(set(blocks.high_x[b]), low_x));
      const auto in_y = hn::And(hn::Le(set(blocks.low_y[b]), high_y), hn::Ge(set(blocks.high_y[b]), low_y));
      const auto in = hn::RebindMask(du, hn::And(in_x, in_y));
      near = hn::Or(near, hn::IfThenElseZero(in, hn::Set(du, std::uint32_t{1} << b)));
    }
    const auto regular = hn::RebindMask(du, hn::Gt(hn::LoadU(d, lanes.regular() + i), hn::Zero(d)));
    near = hn::IfThenElse(regular, near, hn::And(near, hn::Set(du, kExtraBlocks)));
    const auto keep = hn::And(hn::Ne(near, hn::Zero(du)), hn::FirstN(du, lanes.size() - i));
    const V depth = hn::ZeroIfNegative(hn::Sub(hn::LoadU(d, lanes.key() + i), set(job.since)));
    const auto bin = hn::Min(hn::BitCast(du, hn::ConvertTo(di, hn::Mul(depth, per_bin))),
                             hn::Set(du, DepthViewLanes::kBins - 1));
    const auto number = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<std::uint32_t>(i)));
    hn::CompressStore(near, keep, du, lanes.chosen_blocks() + count);
    hn::CompressStore(bin, keep, du, lanes.bin() + count);
    count += hn::CompressStore(number, keep, du, lanes.chosen() + count);
  }
  return count;
}

/// Mask of the rays from number k on that may meet the splat: whatever is outside the larger solid is
/// ignored, as the search may not have found it.
HWY_INLINE auto is_drawn(DepthViewLanes& lanes, std::size_t k, V t, V m2) {
  const D d;
  const auto inside =
      hn::And(hn::Gt(t, hn::Load(d, lanes.near() + k)), hn::Lt(t, hn::Load(d, lanes.far() + k)));
  return hn::And(inside, hn::Lt(m2, set(DepthViewLanes::kEnd * DepthViewLanes::kEnd)));
}

/// Computes the interval of each ray in the larger solid, and where it begins: a quarter of its way through
/// the solid, so that surfaces behind the solid are not taken for surfaces in front of it, and at most at the
/// known depth.
void Bound(const ViewJob& job, const Profile& solid, const Profile& larger, DepthViewLanes lanes) {
  const D d;
  for (std::size_t k = 0; k < DepthViewLanes::kRays; k += hn::Lanes(d)) {
    const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k);
    const Chord chord(larger, x, y);
    hn::Store(chord.near(), d, lanes.near() + k);
    hn::Store(chord.far(), d, lanes.far() + k);
    const Chord own(solid, x, y);
    const V quarter = hn::MulAdd(set(0.25F), own.far(), hn::Mul(set(0.75F), own.near()));
    const V begin = hn::IfThenElse(hn::Gt(own.facing, hn::Zero(d)), quarter, set(job.start));
    hn::Store(hn::Min(hn::Max(begin, set(job.start)), set(job.known)), d, lanes.begin() + k);
  }
}

/// Calls `visit(k)` for each vector of rays, of the blocks in `lit`, that may meet the splat.
template <class Visit>
HWY_INLINE void for_rays(const SplatImage& image, std::uint32_t lit, const Visit& visit) {
  for (std::uint32_t left = lit & image.blocks; left != 0; left &= left - 1) {
    const std::size_t first = DepthView::kBlock * static_cast<std::size_t>(std::countr_zero(left));
    for (std::size_t k = first; k < first + DepthView::kBlock; k += hn::Lanes(D())) visit(k);
  }
}

/// Attenuates all rays up to the depth of the first possible hit.
void Shade(const ViewJob& job, DepthViewLanes lanes) {
  const D d;
  for (const SplatImage& image : lanes.images()) {
    const Drawn splat = Drawn::in_all_lanes(image);
    for_rays(image, ~0U, [&](std::size_t k) HWY_ATTR {
      const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k);
      const V t = splat.depth(x, y), m2 = splat.m2(x, y);
      const auto drawn =
          hn::And(is_drawn(lanes, k, t, m2), hn::And(hn::Gt(t, set(job.since)), hn::Le(t, set(job.start))));
      if (hn::AllFalse(d, drawn)) return;
      const V left = hn::Load(d, lanes.left() + k);
      hn::Store(hn::IfThenElse(drawn, hn::NegMulAdd(left, splat.alpha(m2), left), left), d, lanes.left() + k);
    });
  }
}

/// The blocks with a ray that has transmittance left.
HWY_INLINE std::uint32_t lit_blocks(DepthViewLanes& lanes) {
  const D d;
  std::uint32_t lit = 0;
  for (std::size_t k = 0; k < DepthViewLanes::kRays; k += hn::Lanes(d)) {
    if (!hn::AllTrue(d, hn::Lt(hn::Load(d, lanes.left() + k), set(DepthView::kDark))))
      lit |= 1U << (k / DepthView::kBlock);
  }
  return lit;
}

/// Traces all rays front to back.
void Cast(DepthViewLanes lanes) {
  const D d;
  const DU du;
  for (std::size_t k = 0; k < DepthViewLanes::kRays; k += hn::Lanes(d)) {
    hn::Store(set(DepthView::kNothing), d, lanes.depth() + k);
    hn::Store(hn::Zero(d), d, lanes.sum() + k);
    hn::Store(hn::Zero(d), d, lanes.share() + k);
  }
  constexpr std::size_t kCheckEvery = 16;
  std::uint32_t lit = 0;
  std::size_t count = 0;
  for (const SplatImage& image : lanes.images()) {
    if (count++ % kCheckEvery == 0) lit = lit_blocks(lanes);
    if (lit == 0) break;
    const Drawn splat = Drawn::in_all_lanes(image);
    const auto number = hn::Set(du, image.number);
    for_rays(image, lit, [&](std::size_t k) HWY_ATTR {
      const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k);
      const V t = splat.depth(x, y), m2 = splat.m2(x, y);
      const auto drawn = hn::And(is_drawn(lanes, k, t, m2), hn::Gt(t, hn::Load(d, lanes.begin() + k)));
      if (hn::AllFalse(d, drawn)) return;
      const V before = hn::Load(d, lanes.left() + k);
      const V after = hn::IfThenElse(drawn, hn::NegMulAdd(before, splat.alpha(m2), before), before);
      hn::Store(after, d, lanes.left() + k);
      const V fall = hn::ZeroIfNegative(
          hn::Sub(hn::Min(before, set(DepthViewLanes::kBright)), hn::Max(after, set(DepthViewLanes::kDim))));
      const V share = hn::Mul(fall, set(1.0F / (DepthViewLanes::kBright - DepthViewLanes::kDim)));
      hn::Store(hn::Add(share, hn::Load(d, lanes.share() + k)), d, lanes.share() + k);
      hn::Store(hn::MulAdd(share, t, hn::Load(d, lanes.sum() + k)), d, lanes.sum() + k);
      const auto seen = hn::And(hn::Ge(before, set(DepthView::kSeen)), hn::Lt(after, set(DepthView::kSeen)));
      if (hn::AllFalse(d, seen)) return;
      hn::Store(hn::IfThenElse(seen, t, hn::Load(d, lanes.depth() + k)), d, lanes.depth() + k);
      hn::Store(hn::IfThenElse(hn::RebindMask(du, seen), number, hn::Load(du, lanes.splat() + k)), du,
                lanes.splat() + k);
    });
  }
}

void Clear(const Profile& solid, DepthViewLanes lanes) {
  const D d;
  for (std::size_t k = 0; k < DepthViewLanes::kRays; k += hn::Lanes(d)) {
    const V x = hn::Load(d, lanes.x() + k), y = hn::Load(d, lanes.y() + k),
            z = hn::Load(d, lanes.depth() + k);
    const Chord chord(solid, x, y);
    const auto counts = hn::And(hn::Gt(chord.facing, set(Profile::kLeastFacing * solid.cc)),
                                hn::Lt(z, set(DepthView::kNothing)));
    hn::Store(hn::IfThenElse(counts, hn::Sub(z, chord.far()), set(DepthView::kNothing)), d,
              lanes.clearance() + k);
  }
}

DepthMoments Moments(DepthViewLanes lanes, const DepthKernel& kernel) {
  constexpr std::size_t kTerms = DepthMoments::kTerms;
  const D d;
  const V zero = hn::Zero(d), one = set(1.0F);
  const V unit = set(static_cast<float>(1.0 / kernel.unit)), level = set(static_cast<float>(kernel.level));
  const V center_x = set(static_cast<float>(kernel.center.x())),
          center_y = set(static_cast<float>(kernel.center.y()));
  const float per_end = 1.0F / (kernel.end * kernel.end);
  V matrix[kTerms * (kTerms + 1) / 2], right[kTerms];
  std::fill(std::begin(matrix), std::end(matrix), zero);
  std::fill(std::begin(right), std::end(right), zero);
  V residual = zero, all = zero, through = zero;
  for (std::size_t k = 0; k < DepthViewLanes::kRegular; k += hn::Lanes(d)) {
    const V x = hn::Mul(unit, hn::Sub(hn::Load(d, lanes.x() + k), center_x));
    const V y = hn::Mul(unit, hn::Sub(hn::Load(d, lanes.y() + k), center_y));
    const V share = hn::Load(d, lanes.share() + k);
    const auto hit = hn::Gt(share, zero);
    const V depth = hn::Div(hn::Load(d, lanes.sum() + k), hn::Max(share, set(1e-12F)));
    const V z = hn::IfThenElse(hit, hn::Mul(unit, hn::Sub(depth, level)), zero);
    const V xx = hn::Mul(x, x), yy = hn::Mul(y, y), xy = hn::Mul(x, y), r = hn::Add(xx, yy);
    const V terms[kTerms] = {one, x, y, r, hn::Sub(xx, yy), hn::Add(xy, xy)};
    V fit = set(kernel.fit[0]);
    for (std::size_t i = 1; i < kTerms; ++i) fit = hn::MulAdd(set(kernel.fit[i]), terms[i], fit);
    const V g = hn::ZeroIfNegative(hn::NegMulAdd(r, set(per_end), one));
    const V aim = hn::Mul(g, hn::Mul(g, g));
    const V off = hn::Mul(hn::Sub(z, fit), set(1.0F / kernel.spread)), off2 = hn::Mul(off, off);
    const V w = hn::IfThenElseZero(hit, hn::Div(hn::Mul(share, aim), hn::Add(one, off2)));
    std::size_t at = 0;
    for (std::size_t i = 0; i < kTerms; ++i) {
      const V weighted = hn::Mul(w, terms[i]);
      right[i] = hn::MulAdd(weighted, z, right[i]);
      for (std::size_t j = i; j < kTerms; ++j, ++at) matrix[at] = hn::MulAdd(weighted, terms[j], matrix[at]);
    }
    all = hn::Add(all, aim);
    residual = hn::MulAdd(w, off2, residual);
    through = hn::MulAdd(w, hn::Load(d, lanes.left() + k), through);
  }
  const auto sum = [d](V v) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, v)); };
  DepthMoments result;
  for (std::size_t i = 0; i < result.normal_matrix.size(); ++i) result.normal_matrix[i] = sum(matrix[i]);
  for (std::size_t i = 0; i < kTerms; ++i) result.right[i] = sum(right[i]);
  result.hit = result.normal_matrix[0];
  result.residual = sum(residual) * kernel.spread * kernel.spread;
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
HWY_EXPORT(FindNearest);
HWY_EXPORT(Choose);
HWY_EXPORT(Bound);
HWY_EXPORT(Shade);
HWY_EXPORT(Cast);
HWY_EXPORT(Clear);
HWY_EXPORT(Moments);

using Eigen::Vector3d;

/// Distance of the rows of a triangular lattice with unit spacing.
constexpr double kRow = 0.86602540378443865;
/// Spacing of a pattern relative to its radius: pi / (kRow 0.26^2) = 54 points on average, and never as many
/// as its capacity.
constexpr double kSpacing = 0.26;
/// Position of an unused extra ray, which meets nothing. Unit: [m].
constexpr float kFarAway = 1e6F;

}  // namespace

ViewFrame ViewFrame::along(const Vector3d& w, const Vector3d& origin, const Vector3d& u) {
  const Vector3d aside = u - u.dot(w) * w;
  const double length = aside.norm();
  const Vector3d axis = length > 1e-3 ? Vector3d(aside / length) : w.unitOrthogonal();
  return {origin, axis, w.cross(axis), w};
}

Profile::Profile(const Ellipsoid& solid, const ViewFrame& view) {
  // The axes are orthogonal: the rows of the inverse are the axes over their squared lengths.
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

RayPattern::RayPattern(const Eigen::Matrix2d& shape, const Eigen::Vector2d& center_,
                       const Eigen::Vector2d& anchor_)
    : center(center_),
      aim(center_),
      reach(shape.norm()),
      anchor(anchor_),
      to_cell(shape.inverse() / kSpacing) {
  const Eigen::Vector2d from = to_cell * (anchor - center);
  constexpr int kRows = 6;  // more than 1 / (kRow kSpacing) plus half a cell
  for (int b = -kRows; b <= kRows; ++b) {
    for (int a = -kRows - (b - 1) / 2; a <= kRows - (b - 1) / 2 && size < kMost; ++a) {
      const Eigen::Vector2d place(a + 0.5 * b, kRow * b);
      if ((from + place).squaredNorm() < 1.0 / (kSpacing * kSpacing))
        places[size++] = (anchor + kSpacing * (shape * place)).cast<float>();
    }
  }
}

RayPattern RayPattern::over_ellipse(const Eigen::Matrix2d& shape, const Eigen::Vector2d& lowest) {
  constexpr double kAside = 0.1, kRim = 0.99, kReach = 0.25, kGoldenAngle = 2.39996322972865332;
  RayPattern pattern(shape, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero());
  const auto inside = [&](const Eigen::Vector2d& place) {
    return Eigen::Vector2d(shape * (place * std::min(1.0, kRim / std::max(kRim, place.norm()))));
  };
  const Eigen::Vector2d middle = shape.inverse() * lowest;
  pattern.aim = inside(middle);
  if (middle.norm() < kAside) return pattern;
  for (std::size_t k = 0; k < kAround; ++k) {
    const double r = kReach * std::sqrt((static_cast<double>(k) + 0.5) / kAround);
    const double angle = static_cast<double>(k) * kGoldenAngle;
    const Eigen::Vector2d place = middle + r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    pattern.around[pattern.around_size++] = inside(place).cast<float>();
  }
  return pattern;
}

RayPattern RayPattern::on_lattice(const Eigen::Vector2d& center, double radius, Eigen::Vector2d& anchor) {
  // The lattice point nearest to the centre, to within a cell.
  const double spacing = kSpacing * radius;
  const Eigen::Vector2d away = (center - anchor) / spacing;
  const double j = std::round(away.y() / kRow), i = std::round(away.x() - 0.5 * j);
  anchor += spacing * Eigen::Vector2d(i + 0.5 * j, kRow * j);
  return {radius * Eigen::Matrix2d::Identity(), center, anchor};
}

void DepthView::render(const LocalSplats& splats, const ViewFrame& view, const Profile& profile,
                       const Ellipsoid& larger, const RayPattern& pattern, double start, RayLight& light,
                       double known) {
  start = std::min(start, known);
  ViewJob job{view.u.cast<float>(),
              view.v.cast<float>(),
              view.w.cast<float>(),
              pattern.center.cast<float>(),
              static_cast<float>(pattern.reach),
              static_cast<float>(std::min(start, light.since)),
              static_cast<float>(start),
              static_cast<float>(known),
              static_cast<float>((larger.axes.transpose() * view.w).norm()),
              pattern.anchor.cast<float>(),
              pattern.to_cell.cast<float>()};
  for (std::size_t k = 0; k < kRegular; ++k) {
    x_[k] = k < pattern.size ? pattern.places[k].x() : kFarAway;
    y_[k] = k < pattern.size ? pattern.places[k].y() : kFarAway;
    left_[k] = light.left[k];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double from = view.origin[static_cast<Eigen::Index>(k)];
    for (std::size_t i = 0; i < splats.size; ++i)
      from_[k][i] = static_cast<float>(splats.center[k][i] - from);
  }
  const DepthViewLanes lanes{*this};
  const Profile larger_profile(larger, view);
  HWY_DYNAMIC_DISPATCH(Project)(splats, job, lanes);
  std::array<NearPlace, kSought - kFixed> nearest;
  const std::size_t count = HWY_DYNAMIC_DISPATCH(FindNearest)(job, profile, larger_profile, lanes, nearest);
  aim_extra_rays(pattern, {nearest.data(), count}, light);
  HWY_DYNAMIC_DISPATCH(Bound)(job, profile, larger_profile, lanes);
  bound_blocks();
  order(HWY_DYNAMIC_DISPATCH(Choose)(job, lanes));
  if (job.since < job.start) HWY_DYNAMIC_DISPATCH(Shade)(job, lanes);
  for (std::size_t k = 0; k < kRays; ++k) {
    left_[k] = std::max(left_[k], kSeen);
    if (k < kRegular) light.left[k] = left_[k];
    if (!(near_[k] < far_[k])) left_[k] = 0.0F;  // outside the larger solid
  }
  light.since = start;
  incoming_ = left_;
  HWY_DYNAMIC_DISPATCH(Cast)(lanes);
  HWY_DYNAMIC_DISPATCH(Clear)(profile, lanes);
}

/// Places the extra rays: in the middle, at the aim, where splats are nearest to the solid, and around the
/// aim.
void DepthView::aim_extra_rays(const RayPattern& pattern, std::span<const NearPlace> nearest,
                               const RayLight& light) {
  std::array<Eigen::Vector2f, kExtra> places;
  places.fill(Eigen::Vector2f::Constant(kFarAway));
  places[0] = pattern.center.cast<float>();
  places[1] = pattern.aim.cast<float>();
  for (std::size_t k = 0; k < nearest.size(); ++k) places[kFixed + k] = {nearest[k].x, nearest[k].y};
  std::copy_n(pattern.around.begin(), pattern.around_size, &places[kSought]);
  const bool even = std::ranges::count(light.left, light.left[0]) == std::ssize(light.left);
  for (std::size_t k = 0; k < kExtra; ++k) {
    x_[kRegular + k] = places[k].x();
    y_[kRegular + k] = places[k].y();
    left_[kRegular + k] = light.left[even ? 0 : nearest_regular(places[k].x(), places[k].y())];
  }
}

std::size_t DepthView::nearest_regular(float x, float y) const {
  std::size_t nearest = 0;
  float least = kNothing;
  for (std::size_t k = 0; k < kRegular; ++k) {
    const float away = (x_[k] - x) * (x_[k] - x) + (y_[k] - y) * (y_[k] - y);
    if (away >= least) continue;
    least = away;
    nearest = k;
  }
  return nearest;
}

void DepthView::bound_blocks() {
  for (std::size_t b = 0; b < kBlocks; ++b) {
    float low_x = kNothing, high_x = -kNothing, low_y = kNothing, high_y = -kNothing;
    for (std::size_t k = kBlock * b; k < kBlock * (b + 1); ++k) {
      if (!(near_[k] < far_[k])) continue;
      low_x = std::min(low_x, x_[k]);
      high_x = std::max(high_x, x_[k]);
      low_y = std::min(low_y, y_[k]);
      high_y = std::max(high_y, y_[k]);
    }
    blocks_.low_x[b] = low_x;
    blocks_.high_x[b] = high_x;
    blocks_.low_y[b] = low_y;
    blocks_.high_y[b] = high_y;
  }
}

/// Sorts the selected splats by depth bin: a fraction of the range that is finer than can be felt.
void DepthView::order(std::size_t count) {
  std::array<std::uint32_t, kBins + 1> first{};
  for (std::size_t n = 0; n < count; ++n) ++first[bin_[n] + 1];
  for (std::size_t b = 0; b < kBins; ++b) first[b + 1] += first[b];
  for (std::size_t n = 0; n < count; ++n) images_[first[bin_[n]]++] = image(chosen_[n], chosen_blocks_[n]);
  image_count_ = count;
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
