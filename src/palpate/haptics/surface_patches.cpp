#include <palpate/haptics/surface_patches.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <palpate/geometry/solids.h>
#include <palpate/haptics/image_fit.h>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Views of a new patch, whose position and normal depend on each other.
constexpr int kFirstViews = 3;
/// Largest distance of the offset from that of the nearest ray, in roughnesses: on noise it follows slowly,
/// at an edge at once.
constexpr double kSlack = 2.0;
/// Distance over which the offset follows, in details.
constexpr double kMemory = 2.0;
/// Gap beyond which a patch is dropped, in details.
constexpr double kGone = 0.5;
/// Patches are merged if their normals are within 25 degrees and their positions within the window.
constexpr double kOnePatch = 0.9;
/// Height above a patch's plane up to which a point belongs to the patch, in roughnesses, and in details.
constexpr double kPartOfIt = 3.0, kFlat = 0.1;
/// Least cosine between a view and the normal found in it.
constexpr double kLeastFacing = 0.2;
/// Fraction of rays with a hit from which a surface is whole: thin objects are felt, isolated specks yield.
constexpr double kCovered = 0.25;
/// Opacities of full and of no confidence: less than a tenth of the light transmitted is as hard as none;
/// half of it is no surface.
constexpr double kOpaque = 0.9, kHalf = 0.5;
/// Least confidence of a surface with a hit: it is felt, softly.
constexpr double kSeen = 0.5;

/// Motion of the solid, in details, since the last view within which the surface is assumed to be unchanged.
constexpr double kStill = 0.005;
/// Motion of the foot, in details, within which a patch without hits remains: otherwise a surface that blocks
/// just half of the light would come and go.
constexpr double kLinger = 0.5;
/// Fractions of its window that a patch covers: from kWhole on it is whole, up to kEdge it is an edge.
constexpr double kWhole = 0.5, kEdge = 0.2;
/// Least confidence of a wall, which must also be whole.
constexpr double kCertain = 0.9;
/// Least distance of the beginning of the rays before the last surface, and largest depth of the tool for
/// which it applies, in details: a tip below the surface would otherwise lose sight of it.
constexpr double kKnown = 0.5, kIn = 1.0;
/// A translucent surface is less dense when seen from another side: it recedes from a tool that moves into it
/// over no less than this distance along it, in details, where it transmits half of the light.
constexpr double kHeld = 0.5;
/// Cosine of the largest rotation of a patch per view.
constexpr double kTurned = 0.5;
/// Least cosine between the directions of two views for the rays to be the same.
constexpr double kSameRay = 0.95;

/// The Gaussian with more than half of the weight, if there is one; by weighted majority vote.
std::optional<std::uint32_t> majority(std::span<const PatchWitness> witnesses) {
  std::uint32_t leads = 0;
  double by = 0.0;
  for (const PatchWitness& w : witnesses) {
    by += w.id == leads ? w.weight : -w.weight;
    if (by > 0.0) continue;
    leads = w.id;
    by = -by;
  }
  double share = 0.0;
  for (const PatchWitness& w : witnesses) share += w.id == leads ? w.weight : 0.0;
  return share > 0.5 ? std::optional(leads) : std::nullopt;
}

double smooth_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Ellipsoid scaled(const Ellipsoid& solid, const Vector3d& by) {
  return {solid.center, solid.axes * by.asDiagonal()};
}

/// Normal of a patch: that of the fit where the patch covers the region below the tool; that of the tool at
/// its contact point where only the tool's flank meets something, an edge or a thin object: a plane would
/// extend below the tool where nothing is.
Vector3d towards_contact(const ImageFit& fit, const ViewFrame& view, const Vector2d& slope,
                         const Vector3d& contact) {
  const Vector3d fitted = (slope.x() * view.u + slope.y() * view.v - view.w).normalized();
  const double covered = fit.moments().covered();
  const double whole = smooth_step((covered - kEdge) / (kWhole - kEdge));
  Vector3d normal = (whole * fitted + (1.0 - whole) * contact).normalized();
  // No farther than one view can show.
  while (-normal.dot(view.w) < kTurned) normal = (normal - 0.3 * view.w).normalized();
  return normal;
}

}  // namespace

double confidence_of(const DepthMoments& moments, bool seen) {
  const double least = seen ? kSeen : 0.0;
  if (!(moments.hit > 0.0F)) return least;
  const double covered = moments.covered();
  const double hidden = 1.0 - static_cast<double>(moments.seen_through / moments.hit);
  const double whole = smooth_step(covered / kCovered);
  return least + (1.0 - least) * whole * std::clamp((hidden - kHalf) / (kOpaque - kHalf), 0.0, 1.0);
}

bool SurfacePatches::view(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch,
                          ViewGaps& gaps) {
  const ViewFrame view = ViewFrame::along(-patch.normal, solid.center, patch.tangent);
  const Profile profile(solid, view);
  const Vector2d lowest = image_of(view, farthest_point(solid, -patch.normal));
  const Vector2d place = towards(image_of(view, patch.on_surface()), lowest, detail_);
  if (!is_below(profile, place)) return false;
  Vector2d anchor = image_of(view, patch.anchor);
  RayPattern pattern = RayPattern::on_lattice(place, kWindow * detail_, anchor);
  pattern.aim = image_of(view, patch.sight);
  RayLight light(patch.light);
  const double known = patch.gap > -kIn * detail_
                           ? (solid.center - patch.on_surface()).dot(patch.normal) - kKnown * detail_
                           : std::numeric_limits<double>::infinity();
  view_->render(splats, view, profile, scaled(solid, larger_), pattern, start_of(profile, place), light,
                known);
  budget_.spend_on_view(splats.size, view_->in_window(), view_->drawn());
  budget_.spend_on_fit();
  const std::size_t nearest = view_->nearest();
  if (nearest == DepthView::kRays) return false;
  const double clearance = view_->clearance(nearest);
  ImageFit fit;
  if (!fit.to(*view_, {place, detail_, clearance + depth_of(profile, place), static_cast<float>(kWindow)}))
    return false;
  const Vector3d touching = view.at(view_->x(nearest), view_->y(nearest), view_->depth(nearest) - clearance);
  const ToolSide side(profile, place);
  const Eigen::Matrix2d bend = side.more_than_tool(fit.bend());
  const Vector2d to_least = side.to_least(fit.slope(), bend);
  const Vector3d normal =
      towards_contact(fit, view, fit.slope() + bend * to_least, inward_normal(solid, touching));
  const double facing = normal.dot(patch.normal);
  if (facing < kLeastFacing) return false;
  Vector2d foot = towards(
      place, bend.trace() > 0.0 ? Vector2d(place + to_least) : image_of(view, farthest_point(solid, -normal)),
      detail_);
  if (!is_below(profile, foot)) foot = place;
  const double depth = depth_of(profile, foot);
  gaps.fitted = facing * (fit.depth(foot) - depth);
  gaps.least = facing * clearance;
  patch.sight = view.at(view_->x(nearest), view_->y(nearest), view_->depth(nearest));
  patch.tangent = view.u;
  patch.anchor = view.at(anchor.x(), anchor.y(), fit.depth(anchor));
  patch.normal = normal;
  patch.foot = view.at(foot.x(), foot.y(), depth);
  patch.roughness = fit.roughness();
  patch.confidence = confidence_of(fit.moments(), true);
  patch.covered = fit.moments().covered();
  seen_count_ = 0;
  double sum = 0.0;
  for (std::size_t k = 0; k < DepthView::kRegular; ++k) {
    if (!view_->hits(k)) continue;
    const Vector2d u = (Vector2d(view_->x(k), view_->y(k)) - foot) / detail_;
    const double weight = std::exp(-0.5 * u.squaredNorm());
    seen_[seen_count_++] = {splats.id[view_->splat(k)], splats.position(view_->splat(k)), weight};
    sum += weight;
  }
  for (std::size_t k = 0; k < seen_count_; ++k) seen_[k].weight /= sum;
  patch.mostly = majority({seen_.data(), seen_count_});
  patch.material.reset();
  return true;
}

bool SurfacePatches::keep(const SurfacePatch& patch, std::size_t place) {
  const double near = kWindow * detail_;
  for (std::size_t i = 0; i < size_; ++i) {
    SurfacePatch& other = patches_[i];
    if (other.normal.dot(patch.normal) <= kOnePatch) continue;
    if ((other.on_surface() - patch.on_surface()).squaredNorm() > near * near) continue;
    if (patch.gap < other.gap) {  // the one that constrains the tool more
      other = patch;
      remember_witnesses(i);
    }
    return false;
  }
  patches_[place] = patch;
  remember_witnesses(place);
  size_ = std::max(size_, place + 1);
  return true;
}

void SurfacePatches::remember_witnesses(std::size_t i) {
  std::copy_n(seen_.begin(), seen_count_, witnesses_[i].begin());
  witness_count_[i] = seen_count_;
}

bool SurfacePatches::stay(const Ellipsoid& solid, SurfacePatch& patch) const {
  const Vector3d surface = patch.on_surface();
  patch.foot = carried(patch.seen_by, solid, patch.seen_at);
  patch.gap = (patch.foot - surface).dot(patch.normal);
  const Vector3d way = patch.foot - patch.seen_at;
  const double aside = (way - way.dot(patch.normal) * patch.normal).norm();
  return patch.gap <= kGone * detail_ && aside < kLinger * detail_;
}

bool SurfacePatches::see_again(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch) {
  const Vector3d from = patch.seen_at, surface = patch.on_surface();
  const Vector3d gone = carried(patch.seen_by, solid, from) - from;
  const double hazy = (1.0 - patch.confidence) / (1.0 - kSeen), held = kHeld * detail_ * hazy * hazy;
  ViewGaps seen;
  if (!view(splats, solid, patch, seen)) return false;
  const Vector3d way = patch.foot - from;
  const double along = (way - way.dot(patch.normal) * patch.normal).norm();
  const double wanted = seen.least - seen.fitted, band = kSlack * patch.roughness;
  patch.offset -= std::expm1(-along / (kMemory * detail_)) * (wanted - patch.offset);
  patch.offset = std::clamp(patch.offset, wanted - band, wanted + band);
  const double stays = (patch.foot - surface).dot(patch.normal);
  const double recedes = seen.fitted + patch.offset - stays;
  if (recedes > 0.0 && held > 0.0) {
    const double aside = (gone - gone.dot(patch.normal) * patch.normal).norm();
    patch.offset -= std::exp(-aside / held) * recedes;
  }
  patch.gap = seen.fitted + patch.offset;
  patch.seen_at = patch.foot;
  patch.seen_by = solid;
  return true;
}

void SurfacePatches::follow(const LocalSplats& splats, const Ellipsoid& solid) {
  const std::size_t before = size_;
  size_ = 0;
  for (std::size_t i = 0; i < before; ++i) {
    SurfacePatch patch = patches_[i];  // patches_ is refilled from the front
    const double moved = way_between(patch.viewed_from, solid);
    const bool as_it_was = moved < kStill * detail_ || budget_.is_spent();
    // What a view ahead has added farther away stays until the solid moves: the view may not be complete yet.
    const bool rests = moved == 0.0;
    if (!as_it_was) patch.viewed_from = solid;
    if (as_it_was || !see_again(splats, solid, patch)) {
      if (!stay(solid, patch) && !rests) continue;
      seen_count_ = witness_count_[i];
      std::copy_n(witnesses_[i].begin(), seen_count_, seen_.begin());
    }
    if (rests || patch.gap <= kGone * detail_) keep(patch, size_);
  }
}

void SurfacePatches::carry(const Ellipsoid& solid) {
  for (std::size_t i = 0; i < size_; ++i) stay(solid, patches_[i]);
}

bool SurfacePatches::explained(const Ellipsoid& solid, const Vector3d& point,
                               std::optional<std::uint32_t> of) const {
  for (std::size_t i = 0; i < size_; ++i) {
    const SurfacePatch& patch = patches_[i];
    const Vector3d from = point - patch.on_surface();
    const double above = from.dot(patch.normal);
    if (above > std::max(kPartOfIt * patch.roughness, kFlat * detail_)) {
      // A Gaussian is convex: none of it is above the plane that it constrains the tool with.
      if (of && of == patch.mostly) return true;
      continue;
    }
    // If the lowest point of the tool is above the plane, all of the tool is; otherwise the plane covers only
    // its surroundings.
    const Vector3d lowest = farthest_point(solid, -patch.normal);
    const double slack = (patch.foot - lowest).dot(patch.normal);
    const double aside = (from - above * patch.normal).norm();
    if (slack < kFlat * detail_ || aside < kWindow * detail_) return true;
  }
  return false;
}

void SurfacePatches::carry_light(const Ellipsoid& solid, const Vector3d& along) {
  // In contact, Gaussians beside the tool are not haze that it has passed through.
  const Vector3d moved = solid.center - light_from_;
  const double way = moved.norm(), ahead = moved.dot(along);
  // Nor is haze that it has left another way, through free space, which needs no view.
  const bool elsewhere = way > kLinger * detail_ && ahead < kSameRay * way;
  if (size_ > 0 || elsewhere || along.dot(light_along_) < kSameRay) light_ = RayLight();
  light_.since -= ahead;
  light_from_ = solid.center;
  light_along_ = along;
}

double SurfacePatches::meet(const LocalSplats& splats, const Ellipsoid& solid, const Vector3d& along,
                            const Vector3d& about, double way, double head_on, Meeting& meeting) {
  const ViewFrame view = ViewFrame::along(along, solid.center, solid.axes.col(0));
  const Profile profile(solid, view);
  // The silhouette: the image of the unit sphere.
  Eigen::Matrix<double, 2, 3> image;
  image << view.u.transpose() * solid.axes, view.v.transpose() * solid.axes;
  const Eigen::Matrix2d root = Eigen::Matrix2d(image * image.transpose()).llt().matrixL();
  carry_light(solid, along);
  view_->render(splats, view, profile, scaled(solid, larger_),
                RayPattern::over_ellipse(root, image_of(view, about)), start_of_all(profile, solid, along),
                light_);
  budget_.spend_on_view(splats.size, view_->in_window(), view_->drawn());
  double first = DepthView::kNothing;
  for (std::size_t k = 0; k < DepthView::kRays; ++k) {
    const double clearance = view_->clearance(k);
    if (clearance >= first) continue;
    const Vector3d point = view.at(view_->x(k), view_->y(k), view_->depth(k));
    if (head_on > 0.0 && -inward_normal(solid, point - clearance * along).dot(along) < head_on) continue;
    // Patches do not extend far ahead.
    if (clearance <= std::max(way, kFlat * detail_) && explained(solid, point, splats.id[view_->splat(k)]))
      continue;
    first = clearance;
    meeting = {along, point, clearance, view_->incoming(k)};
  }
  return first;
}

std::size_t SurfacePatches::place_for(const Meeting& meeting, const std::bitset<kMost>& added) const {
  if (size_ < kMost) return size_;
  std::size_t place = kMost;
  double farthest = -kFlat * detail_;
  for (std::size_t i = 0; i < size_; ++i) {
    const double gap_there = patches_[i].gap + meeting.clearance * meeting.along.dot(patches_[i].normal);
    if (added.test(i) || gap_there <= farthest) continue;
    place = i;
    farthest = gap_there;
  }
  return place;
}

bool SurfacePatches::add(const LocalSplats& splats, const Ellipsoid& solid, const Meeting& meeting,
                         bool only_wall, std::size_t place) {
  SurfacePatch patch;
  patch.normal = -meeting.along;
  patch.tangent = meeting.along.unitOrthogonal();
  patch.anchor = patch.sight = meeting.point;
  patch.foot = meeting.point - meeting.clearance * meeting.along;
  patch.gap = meeting.clearance;
  patch.light = meeting.light;
  SurfacePatch best = patch;
  seen_count_ = 0;
  for (int k = 0; k < kFirstViews && (k == 0 || !budget_.is_spent()); ++k) {
    ViewGaps seen;
    if (!view(splats, solid, patch, seen)) break;
    // Contact occurs where the surface is seen along the motion; but along a floor that the part lies on, a
    // ray meets it far inside of the part, however little that is in it.
    const double facing = -meeting.along.dot(patch.normal);
    patch.gap = meeting.clearance < 0.0 && facing < kLeastFacing
                    ? seen.least
                    : meeting.clearance * std::max(kLeastFacing, facing);
    patch.offset = patch.gap - seen.fitted;
    best = patch;
  }
  if (best.gap < -kIn * detail_) return false;
  if (only_wall && (best.covered < kWhole || best.confidence < kCertain)) return false;
  best.seen_at = best.foot;
  best.seen_by = best.viewed_from = solid;
  if (!keep(best, place)) return false;
  ++added_;
  return true;
}

bool SurfacePatches::add_at(const LocalSplats& splats, const Ellipsoid& solid, const Vector3d& normal,
                            const Vector3d& point) {
  if (size_ == kMost || budget_.is_spent() || explained(solid, point, {})) return false;
  SurfacePatch patch;
  patch.normal = normal;
  patch.tangent = normal.unitOrthogonal();
  patch.foot = patch.anchor = patch.sight = point;
  bool found = false;
  for (int k = 0; k < kFirstViews && !budget_.is_spent(); ++k) {
    ViewGaps seen;
    if (!view(splats, solid, patch, seen)) break;
    patch.offset = seen.least - seen.fitted;
    patch.gap = seen.least;
    found = true;
  }
  patch.seen_at = patch.foot;
  patch.seen_by = patch.viewed_from = solid;
  if (!found || !keep(patch, size_)) return false;
  ++added_;
  return true;
}

}  // namespace palpate
