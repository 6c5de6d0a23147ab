/// \file
/// What a live system shows and may be asked for on ROS 1, without ROS headers: these do not compile as
/// C++20.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace palpate::ros1 {

using Vector3 = std::array<double, 3>;

struct SinkPose {
  Vector3 position{};                                     ///< Unit: [m].
  std::array<double, 4> orientation{1.0, 0.0, 0.0, 0.0};  ///< w, x, y, z
};

/// visualization_msgs/Marker in the frame "world".
struct SinkMarker {
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  SinkPose pose;
  Vector3 scale{};
  std::array<double, 4> color{};  ///< r, g, b, a
  std::vector<Vector3> points;
};

/// Pose of the frame `child` in `parent`.
struct SinkTransform {
  std::string parent, child;
  SinkPose pose;
};

/// diagnostic_msgs/DiagnosticStatus.
struct SinkStatus {
  int level = 0;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

/// What services do. Called by the sink's thread; must not block.
struct SinkServices {
  std::function<void()> emergency_stop, resume;
  std::function<void(bool)> pause, clutch;
};

/// Parameters of the node, private names.
struct NodeParameters {
  std::string scene;   ///< ~scene; empty: the built-in one
  std::string config;  ///< ~config: a TOML file as --config takes
  std::string device;  ///< ~device: "/omni,force_max=3.3" (default /omni)
  int decimation = 1;  ///< ~cloud_decimation: of the centres every how manieth
};

/// Initialises ROS with remappings and private names, waits for a master, and reads the parameters. \returns
/// false if it was asked to end before there was a master. \throws std::runtime_error for a parameter that is
/// wrong.
bool init_node(int& argc, char** argv, NodeParameters& parameters);
/// False once the node is asked to end.
bool is_ok();

/// Publishes under the node's namespace: palpate/contacts, palpate/tool (MarkerArray), tf,
/// /diagnostics, and palpate/centers (PointCloud2, latched); serves palpate/emergency_stop, resume (Trigger),
/// pause and clutch (SetBool). One thread. \pre init_node()
class Sink {
 public:
  explicit Sink(SinkServices services);
  ~Sink();
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;

  void publish_contacts(const std::vector<SinkMarker>& markers);
  void publish_tool(const std::vector<SinkMarker>& markers);
  void publish_transforms(const std::vector<SinkTransform>& transforms);
  void publish_status(const SinkStatus& status);
  /// \param points x, y, z each, in "world". Unit: [m].
  void publish_centers(const std::vector<float>& points);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate::ros1
