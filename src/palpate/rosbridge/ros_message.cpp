#include <palpate/rosbridge/ros_message.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace palpate {
namespace {

enum MarkerType { kArrow = 0, kSphere = 2 };
enum MarkerAction { kAdd = 0, kDelete = 2, kDeleteAll = 3 };

Json to_json(const Color& c) { return {{"r", c.r}, {"g", c.g}, {"b", c.b}, {"a", c.a}}; }

Json marker(const Json& header, const std::string& ns, std::uint32_t id, int action) {
  // As a number of 32 bits with a sign, which is what a Marker has.
  return {{"header", header}, {"ns", ns}, {"id", static_cast<std::int32_t>(id)}, {"action", action}};
}

/// What must be there.
double number_at(const Json& message, const char* name) {
  field(message, name);
  return number_field(message, name, 0.0);
}

const Json& object_at(const Json& message, const char* name) {
  const Json& found = field(message, name);
  if (!found.is_object()) throw Refusal(std::string("'") + name + "' must be an object");
  return found;
}

std::int64_t whole_field(const Json& message, const char* name) {
  const auto at = message.find(name);
  return at != message.end() && at->is_number_integer() ? at->get<std::int64_t>() : 0;
}

}  // namespace

Stamp Stamp::now() {
  constexpr std::int64_t kBillion = 1'000'000'000;
  const std::int64_t since = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::system_clock::now().time_since_epoch())
                                 .count();
  return {since / kBillion, since % kBillion};
}

Json header(const Stamp& stamp, const std::string& frame, std::uint64_t seq) {
  return {
      {"seq", seq}, {"stamp", {{"secs", stamp.seconds}, {"nsecs", stamp.nanoseconds}}}, {"frame_id", frame}};
}

Json to_json(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

Json to_json(const Eigen::Quaterniond& q) { return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}; }

Json to_json(const Pose& pose) {
  return {{"position", to_json(pose.position)}, {"orientation", to_json(pose.orientation)}};
}

Json to_json(const Twist& twist) {
  return {{"linear", to_json(twist.linear)}, {"angular", to_json(twist.angular)}};
}

Json to_json(const Wrench& wrench) {
  return {{"force", to_json(wrench.force)}, {"torque", to_json(wrench.torque)}};
}

Json ellipsoid_marker(const Json& header, const std::string& ns, std::uint32_t id, const Ellipsoid& ellipsoid,
                      const Color& color) {
  const Eigen::Vector3d lengths = ellipsoid.axes.colwise().norm();
  // Axes of no length point where they must for a rotation.
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
  // Right-handed whatever the order; the sign of an axis of an ellipsoid is free.
  directions.col(order[2]) = first.cross(second);
  if (directions.determinant() < 0.0) directions.col(order[2]) *= -1.0;

  Json result = marker(header, ns, id, kAdd);
  result["type"] = kSphere;
  result["pose"] = to_json(Pose{ellipsoid.center, Eigen::Quaterniond(directions).normalized()});
  result["scale"] = to_json(Eigen::Vector3d(2.0 * lengths));
  result["color"] = to_json(color);
  return result;
}

Json arrow_marker(const Json& header, const std::string& ns, std::uint32_t id, const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to, double thickness, const Color& color) {
  Json result = marker(header, ns, id, kAdd);
  result["type"] = kArrow;
  result["pose"] = to_json(Pose{});
  result["points"] = {to_json(from), to_json(to)};
  result["scale"] = to_json(Eigen::Vector3d(thickness, 2.0 * thickness, 0.0));
  result["color"] = to_json(color);
  return result;
}

Json deleted_marker(const Json& header, const std::string& ns, std::uint32_t id) {
  return marker(header, ns, id, kDelete);
}

Json all_deleted_marker(const Json& header) { return marker(header, "", 0, kDeleteAll); }

Stamp stamp_of(const Json& header) {
  const auto stamp = header.find("stamp");
  if (stamp == header.end() || !stamp->is_object()) return {};
  const bool first = stamp->contains("secs");
  return {whole_field(*stamp, first ? "secs" : "sec"), whole_field(*stamp, first ? "nsecs" : "nanosec")};
}

StampedPose pose_stamped(const Json& message) {
  StampedPose result;
  if (const auto at = message.find("header"); at != message.end() && at->is_object()) {
    result.frame = text_field(*at, "frame_id");
    result.stamp = stamp_of(*at);
  }
  const Json& pose = object_at(message, "pose");
  const Json& p = object_at(pose, "position");
  const Json& q = object_at(pose, "orientation");
  result.pose.position = {number_at(p, "x"), number_at(p, "y"), number_at(p, "z")};
  result.pose.orientation = {number_at(q, "w"), number_at(q, "x"), number_at(q, "y"), number_at(q, "z")};
  constexpr double kNotUnit = 0.01;
  const double norm = result.pose.orientation.norm();
  if (!(std::abs(norm - 1.0) <= kNotUnit)) throw Refusal("'orientation' must be a unit quaternion");
  constexpr double kFarthest = 1e6;  // m; what is farther is a mistake
  if (!(result.pose.position.norm() <= kFarthest)) throw Refusal("'position' is more than 1000 km away");
  result.pose.orientation.normalize();
  return result;
}

}  // namespace palpate
