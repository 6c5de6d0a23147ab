#include <palpate/rosbridge/marker.h>

#include <algorithm>
#include <array>

namespace palpate {

Marker ellipsoid_marker(const std::string& ns, std::uint32_t id, const Ellipsoid& ellipsoid,
                        const Color& color) {
  const Eigen::Vector3d lengths = ellipsoid.axes.colwise().norm();
  // Axes of zero length get directions that complete a rotation.
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();
  int known = 0;
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return lengths[a] > lengths[b]; });
  while (known < 3 && lengths[order[static_cast<std::size_t>(known)]] > 0.0) ++known;
  Eigen::Vector3d first = Eigen::Vector3d::UnitX(), second;
  if (known > 0) first = ellipsoid.axes.col(order[0]) / lengths[order[0]];
  second =
      known > 1 ? Eigen::Vector3d(ellipsoid.axes.col(order[1]) / lengths[order[1]]) : first.unitOrthogonal();
  second = (second - second.dot(first) * first).normalized();
  directions.col(order[0]) = first;
  directions.col(order[1]) = second;
  // Right-handed in every order; the sign of an ellipsoid's axis is arbitrary.
  directions.col(order[2]) = first.cross(second);
  if (directions.determinant() < 0.0) directions.col(order[2]) *= -1.0;

  Marker marker{ns, id};
  marker.pose = {ellipsoid.center, Eigen::Quaterniond(directions).normalized()};
  marker.scale = 2.0 * lengths;
  marker.color = color;
  return marker;
}

Marker arrow_marker(const std::string& ns, std::uint32_t id, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& to, double thickness, const Color& color) {
  Marker marker{ns, id, Marker::Action::kAdd, Marker::Type::kArrow};
  marker.scale = {thickness, 2.0 * thickness, 0.0};
  marker.color = color;
  marker.points = {from, to};
  return marker;
}

Marker deleted_marker(const std::string& ns, std::uint32_t id) { return {ns, id, Marker::Action::kDelete}; }

Marker all_deleted_marker() { return {"", 0, Marker::Action::kDeleteAll}; }

}  // namespace palpate
