/// \file
/// Configuration of a live system: plain data with default values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <palpate/device/giant_setup.h>
#include <palpate/device/simulated_device.h>
#include <palpate/geometry/similarity.h>
#include <palpate/haptics/density_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/scene_filter.h>
#include <palpate/scene/up_axis.h>
#include <palpate/servo/workspace_map.h>

namespace palpate {

/// \name Choices
/// Each with its names in files and messages, in the order of the enumerators.
/// @{
/// ProxyForce, FieldForce or DensityForce.
enum class ForceModelKind : std::uint8_t { kProxy, kField, kDensity };
inline constexpr std::array<std::string_view, 3> kForceModelNames{"proxy", "field", "density"};

enum class DeviceKind : std::uint8_t {
  kSimulated,    ///< SimulatedDevice in a simulated hand
  kPlayback,     ///< PlaybackDevice: poses of DeviceConfig::trajectory, unaffected by forces
  kClient,       ///< ClientDevice: a gateway client that holds the tool
  kGiant,        ///< GiantDevice, of the admittance type, in a simulated hand, on GiantPlant
  kGiantMujoco,  ///< the same on GiantMujoco
};
inline constexpr std::array<std::string_view, 5> kDeviceKindNames{"simulated", "playback", "client", "giant",
                                                                  "giant-mujoco"};

/// GiantDevice on either plant.
constexpr bool is_giant(DeviceKind kind) {
  return kind == DeviceKind::kGiant || kind == DeviceKind::kGiantMujoco;
}

/// Where the contact search runs.
enum class ContactSearch : std::uint8_t {
  kAuto,    ///< kWorker if a tool may touch hundreds of Gaussians and there is a second core, else kInline
  kInline,  ///< in the servo loop
  kWorker,  ///< in a worker thread that looks ahead of the loop
  kHold,    ///< in a thread that also computes the force, which is held until the next one (as in the paper)
};
inline constexpr std::array<std::string_view, 4> kContactSearchNames{"auto", "inline", "worker", "hold"};

constexpr std::string_view to_string(ForceModelKind kind) {
  return kForceModelNames[static_cast<std::size_t>(kind)];
}
constexpr std::string_view to_string(DeviceKind kind) {
  return kDeviceKindNames[static_cast<std::size_t>(kind)];
}
constexpr std::string_view to_string(ContactSearch search) {
  return kContactSearchNames[static_cast<std::size_t>(search)];
}

/// Returns the model with that name. \throws Error that lists the valid names.
ForceModelKind force_model_kind(std::string_view name);
/// @}

/// Scene file, filter, scale and placement.
struct SceneConfig {
  std::string path;  ///< .ply or .splat; empty: the built-in scene
  SceneFilter filter;
  UpAxis frame = UpAxis::kAsIs;
  Similarity registration;     ///< from the captured frame to the world; its rotation comes after `frame`
  bool no_index_file = false;  ///< neither read nor write SCENE.palpate, the index beside the scene
  /// Whether scale and frame were specified by the user. If not, their values are assumptions that a viewer
  /// may try to improve unless LiveSystem::uses_world(); nothing else depends on these flags.
  bool scale_known = true, frame_known = true;

  bool operator==(const SceneConfig&) const = default;

  /// From the captured frame to the world: mirrors, turns the axis named by `frame` up, then applies
  /// `registration`.
  Similarity world_from_scene() const;
  /// Returns the display name of the file or of the built-in scene.
  std::string name() const;
  /// Returns one sentence on the assumptions about the captured frame.
  std::string frame_note() const;
};

/// Force rendering.
struct ForceConfig {
  ForceModelKind model = ForceModelKind::kProxy;
  ProxyParameters proxy;  ///< its stiffness is that of FieldForce, too; hand_scale, arm_max and materials are
                          ///< set by LiveSystem
  DensityParameters density;  ///< eqs. 9-11
  std::string materials;      ///< file of read_materials(), felt by the proxy; empty: none

  bool operator==(const ForceConfig&) const = default;
};

/// Haptic device, its placement, and the hand that holds it.
struct DeviceConfig {
  DeviceKind kind = DeviceKind::kSimulated;
  std::string driver;  ///< text of make_plugin_device(): that device in place of `kind`; empty: none
  std::string profile = "omega";  ///< of device_profiles(): forces and mechanics of simulated devices
  /// File of read_trajectory(): path of the simulated hand, or poses played by kPlayback, in the world frame.
  /// Empty: the simulated hand explores the scene by touch_path().
  std::string trajectory;
  /// Minimum rate of a client's poses; when three in a row are missing there is no force. Unit: [Hz].
  double client_rate = 60.0;
  HandProperties hand;  ///< holding a simulated device
  /// From the device to the world, without WorkspaceMap::tool. For a giant with the default map, LiveSystem
  /// places the scene below the rest position of the handle.
  WorkspaceMap map;
  /// \name Of a giant; see GiantSetup
  /// @{
  std::string chain = {};                          ///< file of read_chain(); empty: giant_chain()
  double virtual_mass = GiantSetup::kVirtualMass;  ///< Unit: [kg].
  std::optional<double> virtual_damping = {};      ///< Unit: [N s/m].
  /// @}

  bool operator==(const DeviceConfig&) const = default;
};

/// How the servo loop runs.
struct LoopConfig {
  double rate = 1000.0;  ///< Unit: [Hz].
  ContactSearch contacts = ContactSearch::kAuto;
  double worker_delay = 0.0;  ///< artificial additional delay of the worker thread. Unit: [s].
  int cpu = -1;               ///< core that the servo thread is pinned to; -1: any

  bool operator==(const LoopConfig&) const = default;
};

/// Network configuration of a LiveGateway.
struct GatewayConfig {
  static constexpr int kPort = 9090;

  bool off = false;                   ///< serve nothing
  int port = -1;                      ///< 0: any that is free; -1: kPort, or another if that is taken
  std::string address = "127.0.0.1";  ///< local address to listen on
  std::string token;  ///< that clients must present; empty: generated at random if `address` is not a
                      ///< loopback address
  /// Files in PEM, both or neither: everything is served over TLS.
  std::string tls_certificate = {}, tls_key = {};

  bool operator==(const GatewayConfig&) const = default;
};

/// All of a live system. config_fields() describes the fields: their names, units and ranges.
struct LiveConfig {
  SceneConfig scene;
  Tool tool;
  ForceConfig force;
  DeviceConfig device;
  LoopConfig loop;
  GatewayConfig gateway;
  Similarity room;  ///< from the room frame of a headset to the world

  bool operator==(const LiveConfig&) const = default;
};

}  // namespace palpate
