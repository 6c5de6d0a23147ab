#include <palpate/rosbridge/ros_message.h>

#include <chrono>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

Json to_json(const Color& c) { return {{"r", c.r}, {"g", c.g}, {"b", c.b}, {"a", c.a}}; }

/// Returns a required number.
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

Json to_json(const Json& header, const Marker& marker) {
  // A Marker has a signed id of 32 bits.
  Json result{{"header", header},
              {"ns", marker.ns},
              {"id", static_cast<std::int32_t>(marker.id)},
              {"action", static_cast<int>(marker.action)}};
  if (marker.action != Marker::Action::kAdd) return result;
  result["type"] = static_cast<int>(marker.type);
  result["pose"] = to_json(marker.pose);
  result["scale"] = to_json(marker.scale);
  result["color"] = to_json(marker.color);
  if (marker.points.empty()) return result;
  Json points = Json::array();
  for (const Eigen::Vector3d& point : marker.points) points.push_back(to_json(point));
  result["points"] = std::move(points);
  return result;
}

Json marker_array(const Json& header, std::span<const Marker> markers) {
  Json all = Json::array();
  for (const Marker& marker : markers) all.push_back(to_json(header, marker));
  return {{"markers", std::move(all)}};
}

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
  constexpr double kFarthest = 1e6;  // m; beyond it is an error
  if (!(result.pose.position.norm() <= kFarthest))
    throw Refusal("'position' is more than 1000 km from the origin");
  result.pose.orientation.normalize();
  return result;
}

}  // namespace palpate
