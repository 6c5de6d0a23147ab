// The node palpate_ros1: a live system whose device is a driver that speaks CRTK, with what it feels as
// topics.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/crtk_options.h>
#include <palpate/gateway/diagnostics.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/live_system.h>
#include <palpate/servo/live_view.h>

#include "ros1_transport.h"
#include "ros_sink.h"

namespace palpate {
namespace {

using ros1::SinkMarker;
using ros1::SinkPose;

constexpr double kRate = 30.0;        // of markers and tf. Unit: [Hz].
constexpr int kDiagnosticsEvery = 3;  // of those

ros1::Vector3 numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

SinkPose pose_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {numbers(pose.position), {q.w(), q.x(), q.y(), q.z()}};
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

/// What is shown of a system, at its newest tick.
class Show {
 public:
  Show(LiveSystem& system, LiveView& view, ros1::Sink& sink)
      : system_(system), view_(view), sink_(sink), felt_(system.felt()), ellipsoids_(*felt_->index()) {}

  void publish_centers(int decimation) {
    std::vector<float> points;
    int k = 0;
    for (const Ellipsoid& ellipsoid : ellipsoids_.all().ellipsoids) {
      if (k++ % decimation != 0) continue;
      for (const double c : numbers(ellipsoid.center)) points.push_back(static_cast<float>(c));
    }
    sink_.publish_centers(points);
  }

  void publish(double now) {
    view_.update();
    const TickRecord& tick = view_.newest();
    query(*felt_->index(), felt_->tool(), tick.tool, found_);
    sink_.publish_contacts(markers_of(contacts_.next(found_.contacts, ellipsoids_)));
    sink_.publish_tool(markers_of(tool_markers(felt_->tool(), tick.tool)));
    const Pose device{tick.map.offset, tick.map.rotation};
    sink_.publish_transforms({{"world", "palpate/tool", pose_of(tick.tool)},
                              {"world", "palpate/proxy", pose_of(tick.felt.proxy)},
                              {"world", "palpate/device", pose_of(device)}});
    if (count_++ % kDiagnosticsEvery == 0) publish_status(tick, now);
  }

 private:
  void publish_status(const TickRecord& tick, double now) {
    watch_.look(now);
    const LiveDiagnostics found = diagnose(tick, view_.times(), watch_, {});
    ros1::SinkStatus status{found.level, std::string(found.message), {}};
    for (const auto& [key, value] : found.values) status.values.emplace_back(key, value);
    status.values.emplace_back("device", system_.device_fault());
    sink_.publish_status(status);
  }

  LiveSystem& system_;
  LiveView& view_;
  ros1::Sink& sink_;
  std::shared_ptr<const FeltScene> felt_;
  EllipsoidLookup ellipsoids_;
  ContactSet found_;
  ContactMarkers contacts_;
  int count_ = 0;
  RateWatch watch_{system_.loop().statistics()};
};

void say(const std::string& line) { std::fprintf(stderr, "palpate_ros1: %s\n", line.c_str()); }

void run(const ros1::NodeParameters& parameters) {
  LiveConfig config;
  if (!parameters.config.empty()) config = read_live_config(parameters.config);
  if (!parameters.scene.empty()) config.scene.path = parameters.scene;
  CrtkArguments arguments = parse_crtk_arguments("ros1", parameters.device);
  auto device = std::make_unique<CrtkDevice>(std::move(arguments.options),
                                             make_ros1_transport(std::move(arguments.prefix)));
  LiveSystem system(config, std::move(device), say);
  const auto view = std::make_unique<LiveView>();
  if (const auto refused = lock_memory()) say("note: " + *refused);
  system.start({view.get()});
  SafetyGovernor& governor = system.tick().governor();
  ros1::Sink sink({.emergency_stop = [&] { governor.stop(); },
                   .resume = [&] { governor.resume(); },
                   .pause = [&](bool on) { on ? governor.stop(Fault::kPaused) : governor.unpause(); },
                   .clutch = [&](bool on) { system.tick().press_clutch(on); }});
  Show show(system, *view, sink);
  show.publish_centers(parameters.decimation);
  while (ros1::is_ok()) {
    const double now = system.clock().now();
    show.publish(now);
    system.clock().sleep_until(now + 1.0 / kRate);
  }
  system.stop();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  try {
    palpate::ros1::NodeParameters parameters;
    if (palpate::ros1::init_node(argc, argv, parameters)) palpate::run(parameters);
    return 0;
  } catch (const std::exception& error) {
    palpate::say(error.what());
    return 1;
  }
}
