#include <palpate/haptics/confidence.h>

#include <palpate/haptics/surface_fit.h>

namespace palpate {

std::vector<double> confidence(const SceneIndex& index, const Tool& tool, const Pose& pose,
                               const ProxyParameters& parameters, const std::vector<Contact>& contacts) {
  std::vector<double> result;
  SurfaceContacts surface(contacts.size());
  ContactSet around;
  const double extent = index.usual_extent();
  std::size_t part = tool.parts().size();  // that `surface` is of: none yet
  SurfaceKernel kernel{};
  Ellipsoid larger;
  for (const Contact& contact : contacts) {
    if (contact.part != part) {
      part = contact.part;
      kernel = kernel_of(tool.parts()[part], parameters, extent);
      larger = enlarged(tool.parts()[part], kernel).at(pose);
      index.query(larger, Precision::kSingle, around);
      surface.assign(around.contacts, larger, kernel);
    }
    const Eigen::Vector3d u = contact.normal.unitOrthogonal(), v = contact.normal.cross(u);
    const SurfaceFrame frame{((contact.point - larger.center) / kernel.detail).cast<float>(), u.cast<float>(),
                             v.cast<float>(), contact.normal.cast<float>()};
    result.push_back(confidence_of(surface_moments(surface, frame)));
  }
  return result;
}

}  // namespace palpate
