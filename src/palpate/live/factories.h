/// \file
/// Factory functions for the parts of a live system.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/lookahead.h>
#include <palpate/collision/scene_index.h>
#include <palpate/device/giant_setup.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/material.h>
#include <palpate/live/live_config.h>
#include <palpate/record/trajectory.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Material map of a scene; null: one uniform material.
using Materials = std::shared_ptr<const MaterialMap>;

/// Loads the materials from ForceConfig::materials and from the scene's own file or the built-in scene.
/// \param scene SceneConfig::path \throws Error for invalid materials.
Materials load_materials(const ForceConfig& config, const std::string& scene, const Progress& progress = {});

/// Creates a force model of `kind` on an index. `index` and `lookahead` must outlive it; contacts are queried
/// through `lookahead` unless that is null. \param materials used by the proxy model
std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const SceneIndex& index, const Tool& tool,
                                             Materials materials = nullptr, Lookahead* lookahead = nullptr);

/// Creates a force model that is given its contacts, from any query. \throws Error for the proxy model, which
/// queries contacts itself.
std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const Tool& tool);

/// Inputs that a device of DeviceConfig is connected to.
struct DeviceConnections {
  HandPath hand;                      ///< of kSimulated and a giant, in the device's frame
  Trajectory playback;                ///< of kPlayback, in the device's frame
  ClientHand* client_hand = nullptr;  ///< of kClient; must outlive the device
  std::optional<GiantSetup> giant;    ///< of a giant, as giant_setup() returns it
};

/// Creates the device of `config`, not open yet. \param loop_rate LoopConfig::rate, at which simulated
/// devices are read. Unit: [Hz]. \pre the connection for its kind is set \throws Error for an unknown
/// profile; for an admittance that is unstable with GiantSetup::contact_stiffness, naming the violated bound;
/// for MuJoCo if the library was built without it.
std::unique_ptr<HapticDevice> make_device(const DeviceConfig& config, double loop_rate,
                                          DeviceConnections connections);

/// Returns the setup of a giant device from `config`. \param loop_rate LoopConfig::rate. Unit: [Hz]. \param
/// contact_stiffness Unit: [N/m]. \throws Error for a chain that cannot be read.
GiantSetup giant_setup(const DeviceConfig& config, double loop_rate, double contact_stiffness);

/// Creates the mechanics of a giant device, with a hand on path `hand` in the base frame. \param kind kGiant
/// or kGiantMujoco \throws Error for MuJoCo if the library was built without it.
std::unique_ptr<JointPlant> make_giant_plant(DeviceKind kind, const GiantSetup& setup, HandPath hand);

}  // namespace palpate
