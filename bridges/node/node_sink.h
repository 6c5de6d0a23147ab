/// \file
/// What a node shows of a live system and may be asked for, without the headers of ROS, and without
/// Palpate's: ROS 1's do not compile as C++20, and Palpate's not as C++17.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace palpate::node {

using Vector3 = std::array<double, 3>;

struct SinkPose {
  Vector3 position{};                                     ///< Unit: [m].
  std::array<double, 4> orientation{1.0, 0.0, 0.0, 0.0};  ///< w, x, y, z
};

/// visualization_msgs/Marker in the world's frame.
struct SinkMarker {
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  SinkPose pose;
  Vector3 scale{};
  std::array<double, 4> color{};  ///< r, g, b, a
  std::vector<Vector3> points;
};

/// Pose of the frame `child` in the world's.
struct SinkTransform {
  std::string child;
  SinkPose pose;
};

/// diagnostic_msgs/DiagnosticStatus.
struct SinkStatus {
  int level = 0;  ///< 0 fine, 1 warning, 2 error
  std::string name, message, hardware_id;
  std::vector<std::pair<std::string, std::string>> values;
};

/// What services do. Called by the sink's own thread; none blocks.
struct NodeServices {
  std::function<void()> emergency_stop, resume;
  std::function<void(bool)> pause, clutch;
  std::function<std::string()> get_parameters;  ///< the settings as JSON
  std::function<std::string()> config;          ///< a file for --config that starts a run as things are now
  /// Of JSON, settings that are to be others; says what is wrong with it.
  std::function<void(const std::string& json)> set_parameters;
};

/// For services that answer nothing.
inline std::function<std::string()> then_nothing(std::function<void()> work) {
  return [work = std::move(work)] {
    work();
    return std::string();
  };
}

/// A hand as the network sees it.
struct SinkHand {
  std::string prefix;  ///< of its topics and services in the node's namespace: "palpate", "palpate/left"
  NodeServices services;
};

/// Makes the services of a hand, with `trigger(name, std::function<std::string()>)` and `set_bool(name,
/// std::function<void(bool)>)`.
template <class Trigger, class SetBool>
void make_services(const SinkHand& hand, const Trigger& trigger, const SetBool& set_bool) {
  const auto& [prefix, services] = hand;
  trigger(prefix + "/emergency_stop", then_nothing(services.emergency_stop));
  trigger(prefix + "/resume", then_nothing(services.resume));
  trigger(prefix + "/get_parameters", services.get_parameters);
  trigger(prefix + "/config", services.config);
  set_bool(prefix + "/pause", services.pause);
  set_bool(prefix + "/clutch", services.clutch);
}

/// Publishes under the node's namespace contacts and tool (MarkerArray) of each hand, palpate/centers
/// (PointCloud2, kept for who comes later), and /tf and /diagnostics; serves emergency_stop, resume,
/// get_parameters, config (Trigger), pause and clutch (SetBool), and listens to set_parameters (String), of
/// each hand. Everything is stamped when it is published, in the frame `world`. Hands are told by their
/// number. One thread.
class NodeSink {
 public:
  NodeSink() = default;
  virtual ~NodeSink() = default;
  NodeSink(const NodeSink&) = delete;
  NodeSink& operator=(const NodeSink&) = delete;

  /// Whether anybody gets publish_contacts().
  virtual bool wants_contacts(std::size_t hand) const = 0;
  virtual void publish_contacts(std::size_t hand, const std::vector<SinkMarker>& markers) = 0;
  virtual void publish_tool(std::size_t hand, const std::vector<SinkMarker>& markers) = 0;
  virtual void publish_transforms(const std::vector<SinkTransform>& transforms) = 0;
  virtual void publish_diagnostics(const std::vector<SinkStatus>& statuses) = 0;
  /// \param points x, y, z each, in the world. Unit: [m].
  virtual void publish_centers(const std::vector<float>& points) = 0;
};

}  // namespace palpate::node
