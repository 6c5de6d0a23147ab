#include <palpate/haptics/confidence.h>

#include <palpate/haptics/depth_view.h>
#include <palpate/haptics/surface_patches.h>

namespace palpate {

std::vector<double> confidence(const SceneIndex& index, const Tool& tool, const Pose& pose,
                               const ProxyParameters& parameters, const std::vector<Contact>& contacts) {
  std::vector<double> result;
  const double extent = index.usual_extent();
  SplatTracker tracker(index);
  const auto image = std::make_unique<DepthView>();
  for (const Contact& contact : contacts) {
    const ToolPart& part = tool.parts()[contact.part];
    const double detail = detail_of(part, parameters), reach = reach_of(part, detail, extent);
    const Ellipsoid solid = part.at(pose), larger = enlarged(part, detail, reach).at(pose);
    const LocalSplats& splats = tracker.around(larger);
    const ViewFrame view = ViewFrame::along(-contact.normal, solid.center, contact.normal.unitOrthogonal());
    const Eigen::Vector3d from = contact.point - view.origin;
    const Eigen::Vector2d place(from.dot(view.u), from.dot(view.v));
    const double depth = from.dot(view.w);
    Eigen::Vector2d anchor = place;
    const double window = SurfacePatches::kWindow;
    RayLight light;
    image->render(splats, view, Profile(solid, view), larger,
                  RayPattern::on_lattice(place, window * detail, anchor), depth - 2.0 * detail, light);
    result.push_back(confidence_of(image->moments({place, detail, depth, static_cast<float>(window)}),
                                   image->nearest() < DepthView::kRays));
  }
  return result;
}

}  // namespace palpate
