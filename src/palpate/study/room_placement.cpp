#include <palpate/study/room_placement.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/device/giant_setup.h>
#include <palpate/scene/scene_setup.h>
#include <palpate/study/capture_defects.h>

namespace palpate {
namespace {

/// Placement of a scene beside the rest position of the handle: its largest size, its distance in y from
/// there, and the distance of its top below the handle's reach, with room to walk around and to pass above.
/// Unit: [m].
const Eigen::Vector3d kFits(3.5, 1.9, 1.3);
constexpr double kAside = 0.35, kBelow = 0.18;
/// Placement of a larger scene below the rest position of the handle: size of the room to fill, distance of
/// its top below the handle, and number of its Gaussians in the room: the paper's million, and a margin that
/// was chosen by trial on one captured city, where contacts then have about as many Gaussians as the paper's.
/// Unit: [m], [m], 1.
const Eigen::Array2d kRoom(4.2, 5.0);
constexpr double kUnderHandle = 0.1;
constexpr std::size_t kFilling = 1'150'000;

/// Returns the ellipsoids that the placement keeps. \throws Error if there are none.
EllipsoidScene kept_of(const GaussianScene& scene, const RoomPlacement& placement) {
  FilterReport report;
  EllipsoidScene kept =
      filter_scene(scene, placement.filter, upright(placement.frame, placement.registration), report);
  if (kept.size() == 0) throw Error("{}: no Gaussian passes the filter; lower --opacity-min", scene.source);
  return kept;
}

/// Factor by which `kept` can be enlarged to leave kFilling of it in kRoom about `middle`; at least 1.
double enlarged_to_fill(const EllipsoidScene& kept, const Eigen::Vector3d& middle) {
  if (kept.size() <= kFilling) return 1.0;
  std::vector<double> share;  // fraction of the room at which a centre is
  for (const Ellipsoid& e : kept.ellipsoids)
    share.push_back(((e.center - middle).head<2>().array().abs() / (0.5 * kRoom)).maxCoeff());
  std::nth_element(share.begin(), share.begin() + kFilling, share.end());
  return std::max(1.0, 1.0 / share[kFilling]);
}

/// Enlarges a scene that is larger than the room to fill it, and crops it about its middle. \returns the box
/// of the remainder.
Eigen::AlignedBox3d crop_to_room(const GaussianScene& scene, RoomPlacement& placement,
                                 const EllipsoidScene& kept, const Eigen::Vector3d& middle) {
  const double larger = enlarged_to_fill(kept, middle);
  placement.registration.scale *= larger;
  const Eigen::Vector3d half(0.5 * kRoom.x(), 0.5 * kRoom.y(), std::numeric_limits<double>::max());
  auto& crop = placement.filter.crop_box.emplace(larger * middle - half, larger * middle + half);
  const Eigen::AlignedBox3d box = central_box(kept_of(scene, placement));
  crop.min().z() = box.min().z();
  crop.max().z() = box.max().z();
  return box;
}

}  // namespace

RoomPlacement place_in_room(const GaussianScene& scene, const SceneFilter& filter, double tool_radius,
                            const Eigen::Vector3d& home) {
  RoomPlacement placement{UpAxis::kAsIs, {}, filter};
  const bool captured = scene.format != "procedural";
  Similarity& placed = placement.registration;
  if (captured) {
    const SceneSetup proposed = propose_setup(scene, tool_radius);
    placement.frame = proposed.frame.value;
    placed.scale = proposed.scale.value;
  }
  const EllipsoidScene kept = kept_of(scene, placement);
  Eigen::AlignedBox3d box = central_box(kept);
  if (!captured) {
    placed.scale = (kFits.array() / box.sizes().array()).minCoeff();
    box = {placed.scale * box.min(), placed.scale * box.max()};
  }
  const bool below = (box.sizes().array() > 1.001 * kFits.array()).any() && !placement.filter.crop_box;
  if (below) box = crop_to_room(scene, placement, kept, box.center());
  const Eigen::Vector3d top =
      below ? Eigen::Vector3d(0.0, 0.0, home.z() - kUnderHandle)
            : Eigen::Vector3d(0.0, -kAside - 0.5 * box.sizes().y(), giant_reach().max().z() - kBelow);
  placed.translation = top - Eigen::Vector3d(box.center().x(), box.center().y(), box.max().z());
  if (below) placement.filter.crop_box->translate(placed.translation);
  return placement;
}

GaussianScene procedural_truck(const AnalyticSurface& surface, std::uint64_t seed) {
  ProceduralOptions made;
  made.seed = seed;
  made.spacing = 0.0068;  // a million on its surface
  made.noise = 0.001;
  CaptureDefects defects;
  defects.floaters = defects.faint = true;
  return make_capture(surface, made, defects);
}

}  // namespace palpate
