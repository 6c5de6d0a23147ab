/// \file
/// What a node shows of a live system and may be asked for, without the headers of ROS, and without
/// Palpate's: ROS 1's do not compile as C++20, and Palpate's not as C++17.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <type_traits>
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

/// What services do, each Pace on a thread of the sink's own. What they return is the answer's message; what
/// they throw (std::exception) is why they refuse.
struct NodeServices {
  /// \name Pace::kQuick
  /// @{
  std::function<void()> emergency_stop, resume;
  std::function<void(bool)> pause, clutch;
  std::function<std::string()> get_parameters;  ///< the settings, and what is felt, as JSON
  std::function<std::string()> config;          ///< a file for --config that starts a run as things are now
  /// Of JSON, settings that are to be others; says what is wrong with it, and does not throw.
  std::function<void(const std::string& json)> set_parameters;
  /// @}
  /// \name Pace::kSlow
  /// @{
  /// True: begins a recording, false: ends it. Tells its file, once that is there, or whole.
  std::function<std::string(bool)> record;
  /// \name Of the first hand alone
  /// @{
  std::function<std::string()> list_scenes;  ///< those that open_scene knows, as JSON
  /// Another scene is to be felt; says what is wrong, and does not throw.
  std::function<void(const std::string& which)> open_scene;
  /// @}
  /// @}
};

/// Whether a service may wait, for a disk, and others with it: never those that end the force.
enum class Pace { kQuick, kSlow };

/// A hand as the network sees it.
struct SinkHand {
  std::string prefix;  ///< of its topics and services in the node's namespace: "palpate", "palpate/left"
  NodeServices services;
};

/// std_srvs/Trigger and SetBool answer this.
struct Answer {
  bool success = true;
  std::string message = {};
};

/// What `work` comes to.
template <class Work>
Answer answer_of(const Work& work) {
  try {
    if constexpr (std::is_void_v<decltype(work())>) {
      work();
      return {};
    } else {
      return {true, work()};
    }
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
}

/// `work`, as what answers a call of it.
template <class Result>
std::function<Answer()> answering(std::function<Result()> work) {
  return [work = std::move(work)] { return answer_of(work); };
}
template <class Result>
std::function<Answer(bool)> answering(std::function<Result(bool)> work) {
  return [work = std::move(work)](bool data) { return answer_of([&] { return work(data); }); };
}

/// Makes the services of a hand that have this pace, with `trigger(name, std::function<Answer()>)` and
/// `set_bool(name, std::function<Answer(bool)>)`.
template <class Trigger, class SetBool>
void make_services(const SinkHand& hand, Pace pace, const Trigger& trigger, const SetBool& set_bool) {
  const auto& [prefix, services] = hand;
  if (pace == Pace::kSlow) {
    set_bool(prefix + "/record", answering(services.record));
    if (services.list_scenes) trigger(prefix + "/list_scenes", answering(services.list_scenes));
    return;
  }
  trigger(prefix + "/emergency_stop", answering(services.emergency_stop));
  trigger(prefix + "/resume", answering(services.resume));
  trigger(prefix + "/get_parameters", answering(services.get_parameters));
  trigger(prefix + "/config", answering(services.config));
  set_bool(prefix + "/pause", answering(services.pause));
  set_bool(prefix + "/clutch", answering(services.clutch));
}

/// Has what a hand is told at this pace heard, with `listen(name, std::function<void(const std::string&)>)`.
/// These are topics, for std_srvs has no service that takes text.
template <class Listen>
void make_listeners(const SinkHand& hand, Pace pace, const Listen& listen) {
  const auto& [prefix, services] = hand;
  if (pace == Pace::kQuick) listen(prefix + "/set_parameters", services.set_parameters);
  if (pace == Pace::kSlow && services.open_scene) listen(prefix + "/open_scene", services.open_scene);
}

/// Publishes under the node's namespace contacts and tool (MarkerArray) of each hand, palpate/centers
/// (PointCloud2, kept for who comes later), and /tf and /diagnostics; has each hand's NodeServices as
/// services and topics. Everything is stamped when it is published, in the frame `world`. Hands are told by
/// their number. One thread.
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
