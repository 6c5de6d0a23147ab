/// \file
/// Topics and services of a node. Includes neither ROS nor Palpate headers: those of ROS 1 do not compile as
/// C++20, and Palpate's do not compile as C++17.
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

/// visualization_msgs/Marker in the world frame.
struct SinkMarker {
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  SinkPose pose;
  Vector3 scale{};
  std::array<double, 4> color{};  ///< r, g, b, a
  std::vector<Vector3> points;
};

/// Pose of the frame `child` in the world frame.
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

/// Service callbacks. Each Pace has its own thread in the sink. The return value is the message of the
/// response; the text of a thrown std::exception is the reason of a failure.
struct NodeServices {
  /// \name Pace::kAtOnce
  /// @{
  std::function<void()> emergency_stop;
  std::function<void(bool)> pause;
  /// @}
  /// \name Pace::kQuick
  /// @{
  std::function<void()> resume;
  std::function<void(bool)> clutch;
  std::function<std::string()> get_parameters;  ///< settings and current scene as JSON
  std::function<std::string()> config;          ///< a --config file with the current settings
  /// Changes the settings given in JSON. Reports errors as notices; does not throw.
  std::function<void(const std::string& json)> set_parameters;
  /// @}
  /// \name Pace::kSlow
  /// @{
  /// Starts (true) or ends (false) a recording. \returns its file, once created or complete.
  std::function<std::string(bool)> record;
  /// \name First hand only
  /// @{
  std::function<std::string()> list_scenes;  ///< the scenes that open_scene accepts, as JSON
  /// Opens another scene. Reports errors as notices; does not throw.
  std::function<void(const std::string& which)> open_scene;
  /// @}
  /// @}
};

/// How long a service may take, and so delay others of the same pace, however often it is called: services
/// that end the force are at once, and wait for nothing else; slow ones may wait for a disk.
enum class Pace { kAtOnce, kQuick, kSlow };
inline constexpr std::array kPaces{Pace::kAtOnce, Pace::kQuick, Pace::kSlow};

/// Topics and services of a hand.
struct SinkHand {
  std::string prefix;  ///< of topics and services, in the node's namespace: "palpate", "palpate/left"
  NodeServices services;
};

/// Response of std_srvs/Trigger and SetBool.
struct Answer {
  bool success = true;
  std::string message = {};
};

/// Runs `work` and converts its result or exception to a response.
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

/// Wraps `work` in a function that returns the response.
template <class Result>
std::function<Answer()> answering(std::function<Result()> work) {
  return [work = std::move(work)] { return answer_of(work); };
}
template <class Result>
std::function<Answer(bool)> answering(std::function<Result(bool)> work) {
  return [work = std::move(work)](bool data) { return answer_of([&] { return work(data); }); };
}

/// Creates the services of a hand that have this pace, with `trigger(name, std::function<Answer()>)` and
/// `set_bool(name, std::function<Answer(bool)>)`.
template <class Trigger, class SetBool>
void make_services(const SinkHand& hand, Pace pace, const Trigger& trigger, const SetBool& set_bool) {
  const auto& [prefix, services] = hand;
  switch (pace) {
    case Pace::kAtOnce:
      trigger(prefix + "/emergency_stop", answering(services.emergency_stop));
      set_bool(prefix + "/pause", answering(services.pause));
      break;
    case Pace::kQuick:
      trigger(prefix + "/resume", answering(services.resume));
      trigger(prefix + "/get_parameters", answering(services.get_parameters));
      trigger(prefix + "/config", answering(services.config));
      set_bool(prefix + "/clutch", answering(services.clutch));
      break;
    case Pace::kSlow:
      set_bool(prefix + "/record", answering(services.record));
      if (services.list_scenes) trigger(prefix + "/list_scenes", answering(services.list_scenes));
      break;
  }
}

/// Creates the text subscriptions of a hand that have this pace, with
/// `listen(name, std::function<void(const std::string&)>)`. They are topics because std_srvs has no service
/// with a text argument.
template <class Listen>
void make_listeners(const SinkHand& hand, Pace pace, const Listen& listen) {
  const auto& [prefix, services] = hand;
  if (pace == Pace::kQuick) listen(prefix + "/set_parameters", services.set_parameters);
  if (pace == Pace::kSlow && services.open_scene) listen(prefix + "/open_scene", services.open_scene);
}

/// Publishes in the node's namespace contacts and tool (MarkerArray) of each hand and palpate/centers
/// (PointCloud2, latched), and publishes /tf and /diagnostics; provides each hand's NodeServices as services
/// and topics. Messages are stamped with the time of publication, in the world frame. Hands are identified by
/// their index. One thread.
class NodeSink {
 public:
  NodeSink() = default;
  virtual ~NodeSink() = default;
  NodeSink(const NodeSink&) = delete;
  NodeSink& operator=(const NodeSink&) = delete;

  /// Returns whether the contacts have subscribers.
  virtual bool wants_contacts(std::size_t hand) const = 0;
  virtual void publish_contacts(std::size_t hand, const std::vector<SinkMarker>& markers) = 0;
  virtual void publish_tool(std::size_t hand, const std::vector<SinkMarker>& markers) = 0;
  virtual void publish_transforms(const std::vector<SinkTransform>& transforms) = 0;
  virtual void publish_diagnostics(const std::vector<SinkStatus>& statuses) = 0;
  /// \param points x, y, z of each centre, world frame. Unit: [m].
  virtual void publish_centers(const std::vector<float>& points) = 0;
};

}  // namespace palpate::node
