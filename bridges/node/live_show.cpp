#include "live_show.h"

#include <fmt/format.h>
#include <algorithm>

#include <palpate/haptics/tool_query.h>

#include "node_scenes.h"

namespace palpate::node {
namespace {

/// Duration of the warning after a dropped pose. Unit: [s].
constexpr double kDropped = 1.0;

Vector3 numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

SinkPose pose_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {numbers(pose.position), {q.w(), q.x(), q.y(), q.z()}};
}

bool is_finite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

std::vector<SinkMarker> markers_of(const std::vector<Marker>& markers) {
  std::vector<SinkMarker> all;
  for (const Marker& m : markers) {
    SinkMarker& out = all.emplace_back();
    out.ns = m.ns;
    out.id = static_cast<std::int32_t>(m.id);
    out.type = static_cast<int>(m.type);
    out.action = static_cast<int>(m.action);
    out.pose = pose_of(m.pose);
    out.scale = numbers(m.scale);
    out.color = {m.color.r, m.color.g, m.color.b, m.color.a};
    for (const Eigen::Vector3d& point : m.points) out.points.push_back(numbers(point));
  }
  return all;
}

}  // namespace

LiveShow::LiveShow(const ShownHand& hand, const std::string& tf_prefix, NodeSink& sink)
    : hand_(hand),
      frames_(tf_prefix + (is_first() ? "" : hand.settings.name + "/")),
      sink_(sink),
      felt_(hand.system.felt()),
      watch_(hand.system.loop().statistics()) {}

void LiveShow::update(const ShownScene* scene) {
  hand_.view.update();
  felt_ = hand_.system.felt();  // the scene or the tool may have changed
  if (scene != nullptr && sink_.wants_contacts(hand_.number)) publish_contacts(*scene);
  sink_.publish_tool(hand_.number, markers_of(tool_markers(felt_->tool(), hand_.view.newest().tool)));
  say_failures();
}

/// Contacts are computed here, so that subscribers cost the loop nothing.
void LiveShow::publish_contacts(const ShownScene& scene) {
  found_.contacts.clear();
  if (scene.index == felt_->index())
    query(*felt_->index(), felt_->tool(), hand_.view.newest().tool, ToolTracker::kMost, found_);
  sink_.publish_contacts(hand_.number, markers_of(contacts_.next(found_.contacts, scene.ellipsoids)));
}

void LiveShow::say_failures() {
  if (const std::string ended = hand_.recording.look(); !ended.empty()) hand_.notices.say(ended);
  const std::uint64_t version = hand_.system.version();
  if (version == said_) return;
  said_ = version;
  if (const std::string failure = hand_.system.message(); !failure.empty()) hand_.notices.say(failure);
}

/// tf cannot represent the scales of the workspace and the scene.
void LiveShow::add_transforms(std::vector<SinkTransform>& all) const {
  const TickRecord& tick = hand_.view.newest();
  const Similarity scene = hand_.system.settings().scene.world_from_scene();
  all.push_back({hand_.settings.device_frame, pose_of({tick.map.offset, tick.map.rotation})});
  if (is_first()) all.push_back({frames_ + "scene", pose_of({scene.translation, scene.rotation})});
  all.push_back({frames_ + "tool", pose_of(tick.tool)});
  if (is_finite(tick.felt.proxy)) all.push_back({frames_ + "proxy", pose_of(tick.felt.proxy)});
}

void LiveShow::add_statuses(std::vector<SinkStatus>& all) {
  const double now = hand_.system.clock().now();
  watch_.update(now);
  const std::string of = is_first() ? "palpate" : "palpate/" + hand_.settings.name;
  all.push_back(servo_status(of + ": servo"));
  all.push_back(device_status(of + ": device", now));
  all.push_back(scene_status(of + ": scene"));
}

SinkStatus LiveShow::servo_status(std::string name) const {
  const LiveDiagnostics found = diagnose(hand_.view.newest(), hand_.view.times(), watch_, {});
  SinkStatus status{found.level, std::move(name), std::string(found.message), {}, {}};
  for (const auto& [key, value] : found.values) status.values.emplace_back(key, value);
  return status;
}

SinkStatus LiveShow::device_status(std::string name, double now) {
  const CrtkDevice& device = hand_.device;
  const std::uint64_t dropped = device.dropped();
  if (dropped != std::exchange(dropped_, dropped)) dropped_at_ = now;
  const std::string fault(hand_.system.device_fault());
  const NodeNotices::Said said = hand_.notices.said();
  SinkStatus status{0, std::move(name), "receiving poses", device.capabilities().name, {}};
  if (!fault.empty()) {
    status.level = 2;
    status.message = fault;
  } else if (now - dropped_at_ < kDropped) {
    status.level = 1;
    status.message = "poses are dropped";
  } else if (hand_.view.newest().fault == Fault::kStalePose) {
    status.level = 1;
    status.message = "no poses received";
  } else if (!device.has_listener()) {
    status.level = 1;
    status.message = "nothing subscribes to the wrenches: no force";
  }
  status.values = {{"taken", fmt::format("{}", device.taken())},
                   {"dropped", fmt::format("{}", dropped)},
                   {"notice", said.newest},
                   {"notices", fmt::format("{}", said.count)}};
  return status;
}

SinkStatus LiveShow::scene_status(std::string name) const {
  const std::string busy = hand_.system.busy();
  const std::string failure = hand_.system.message();
  SinkStatus status{0, std::move(name), "scene active", hand_.device.capabilities().name, {}};
  if (!failure.empty()) status = {1, status.name, failure, status.hardware_id, {}};
  if (!busy.empty()) status.message = busy;
  status.values = {{"scene", felt_name(hand_.system)}, {"recording", hand_.recording.path()}};
  return status;
}

void publish(std::deque<LiveShow>& shows, const ShownScene* scene, NodeSink& sink, bool diagnostics) {
  std::vector<SinkTransform> transforms;
  std::vector<SinkStatus> statuses;
  for (LiveShow& show : shows) {
    show.update(scene);
    show.add_transforms(transforms);
    if (diagnostics) show.add_statuses(statuses);
  }
  sink.publish_transforms(transforms);
  if (diagnostics) sink.publish_diagnostics(statuses);
}

}  // namespace palpate::node
