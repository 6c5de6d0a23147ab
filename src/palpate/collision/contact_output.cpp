#include <palpate/collision/contact_output.h>

#include <cmath>

#include <palpate/collision/exact_k.h>

namespace palpate {
namespace {

/// A Gaussian in the captured frame, relative to the index's origin.
Ellipsoid captured_ellipsoid(const GaussianBlock& block, std::size_t lane) {
  const auto sum = [&](std::size_t axis) {
    return static_cast<double>(block.length_high[axis][lane]) +
           static_cast<double>(block.length_low[axis][lane]);
  };
  const Eigen::Quaterniond q(block.rotation[0][lane], block.rotation[1][lane], block.rotation[2][lane],
                             block.rotation[3][lane]);
  const Eigen::Vector3d lengths(sum(0), sum(1), sum(2));
  return {{block.position[0][lane], block.position[1][lane], block.position[2][lane]},
          q.normalized().toRotationMatrix() * lengths.asDiagonal()};
}

/// Bound of the error of K_min where it is near 0.
double rounding_of(const KFunction& k, const DoubleRounding& r) {
  return std::sqrt(r.constant + r.per_distance * k.p0 + r.per_extent * k.e1);
}

}  // namespace

bool scalar_contact(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, Contact& contact) {
  const Ellipsoid gaussian = captured_ellipsoid(block, lane);
  const Ellipsoid& solid = tool.world.ellipsoid;  // its axes are W^-1
  const Eigen::Vector3d distance = tool.W * (tool.center - gaussian.center);
  const Eigen::Matrix3d l = tool.W * gaussian.axes;
  const KFunction k(distance, l);
  KMinimum minimum = minimize(k);
  if (std::abs(minimum.k_min) <= rounding_of(k, tool.rounding))
    minimum.k_min = exact_k_min(block, lane, tool, minimum.log_t);
  if (!(minimum.k_min > 0.0)) return false;
  const Contact label = contact;
  contact = make_contact(tool.world, {solid.center - solid.axes * distance, solid.axes * l}, k, minimum);
  contact.id = label.id;
  contact.opacity = label.opacity;
  contact.extent = label.extent;
  return true;
}

}  // namespace palpate
