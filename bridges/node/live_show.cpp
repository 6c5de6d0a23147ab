#include "live_show.h"

#include <fmt/format.h>
#include <algorithm>

#include <palpate/haptics/tool_query.h>

namespace palpate::node {
namespace {

/// After the last pose that was dropped it is still a warning. Unit: [s].
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

LiveShow::LiveShow(LiveSystem& system, const CrtkDevice& device, LiveView& view, const NodeNotices& notices,
                   const NodeSettings& settings, NodeSink& sink)
    : system_(system),
      device_(device),
      view_(view),
      notices_(notices),
      settings_(settings),
      sink_(sink),
      felt_(system.felt()),
      ellipsoids_(*felt_->index()),
      watch_(system.loop().statistics()) {}

void LiveShow::publish_centers() {
  std::vector<float> points;
  const auto all = ellipsoids_.all();
  const auto step = static_cast<std::size_t>(settings_.decimation);
  for (std::size_t i = 0; i < all.ellipsoids.size(); i += step)
    for (const double c : numbers(all.ellipsoids[i].center)) points.push_back(static_cast<float>(c));
  sink_.publish_centers(points);
}

void LiveShow::publish(double now) {
  view_.update();
  const TickRecord& tick = view_.newest();
  if (sink_.wants_contacts()) publish_contacts(tick);
  sink_.publish_tool(markers_of(tool_markers(felt_->tool(), tick.tool)));
  publish_transforms(tick);
  watch_.look(now);
  if (count_++ % kDiagnosticsEvery == 0)
    sink_.publish_diagnostics({servo_status(tick), device_status(tick, now)});
}

/// Looked for here, so that the loop does nothing for those who look on.
void LiveShow::publish_contacts(const TickRecord& tick) {
  query(*felt_->index(), felt_->tool(), tick.tool, found_);
  sink_.publish_contacts(markers_of(contacts_.next(found_.contacts, ellipsoids_)));
}

/// Scales, of the workspace and of the scene, have no place in tf.
void LiveShow::publish_transforms(const TickRecord& tick) {
  const Similarity scene = system_.settings().scene.world_from_scene();
  const std::string& prefix = settings_.tf_prefix;
  std::vector<SinkTransform> all{{settings_.device_frame, pose_of({tick.map.offset, tick.map.rotation})},
                                 {prefix + "scene", pose_of({scene.translation, scene.rotation})},
                                 {prefix + "tool", pose_of(tick.tool)}};
  if (is_finite(tick.felt.proxy)) all.push_back({prefix + "proxy", pose_of(tick.felt.proxy)});
  sink_.publish_transforms(all);
}

SinkStatus LiveShow::servo_status(const TickRecord& tick) const {
  const LiveDiagnostics found = diagnose(tick, view_.times(), watch_, {});
  SinkStatus status{found.level, "palpate: servo", std::string(found.message), {}, {}};
  for (const auto& [key, value] : found.values) status.values.emplace_back(key, value);
  return status;
}

SinkStatus LiveShow::device_status(const TickRecord& tick, double now) {
  const std::uint64_t dropped = device_.dropped();
  if (dropped != std::exchange(dropped_, dropped)) dropped_at_ = now;
  const std::string fault(system_.device_fault());
  const NodeNotices::Said said = notices_.said();
  SinkStatus status{0, "palpate: device", "poses come", device_.capabilities().name, {}};
  if (!fault.empty()) {
    status.level = 2;
    status.message = fault;
  } else if (now - dropped_at_ < kDropped) {
    status.level = 1;
    status.message = "poses are dropped";
  } else if (tick.fault == Fault::kStalePose) {
    status.level = 1;
    status.message = "no poses come";
  }
  status.values = {{"taken", fmt::format("{}", device_.taken())},
                   {"dropped", fmt::format("{}", dropped)},
                   {"notice", said.newest},
                   {"notices", fmt::format("{}", said.count)}};
  return status;
}

}  // namespace palpate::node
