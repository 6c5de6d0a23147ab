#include <palpate/collision/contact_output.h>

namespace palpate {

bool scalar_contact(const CapturedSolid& gaussian, const ToolFrame& tool, Contact& contact) {
  const Ellipsoid& solid = tool.world.ellipsoid;  // its axes are W^-1
  const Eigen::Vector3d distance = tool.W * (tool.center - gaussian.center);
  const Eigen::Matrix3d l = tool.W * gaussian.axes;
  const KFunction k(distance, l);
  const KMinimum minimum = minimize(k);
  if (!(minimum.k_min > 0.0)) return false;
  Contact found =
      make_contact(tool.world, {solid.center - solid.axes * distance, solid.axes * l}, k, minimum);
  found.id = contact.id;
  found.opacity = contact.opacity;
  contact = found;
  return true;
}

}  // namespace palpate
