/// \file
/// Factories of the parts of a live system from its configuration.
#pragma once

#include <memory>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/lookahead.h>
#include <palpate/collision/scene_index.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/material.h>
#include <palpate/live/live_config.h>
#include <palpate/record/trajectory.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// What a scene is made of; null: of one stuff all over.
using Materials = std::shared_ptr<const MaterialMap>;

/// What ForceConfig::materials and the scene's own file say. \param scene SceneConfig::path \throws Error for
/// broken materials.
Materials load_materials(const ForceConfig& config, const std::string& scene, const Progress& progress = {});

/// A model of `kind` on an index, which must outlive it, as `lookahead` must, through which it looks for
/// contacts where that is not null. \param materials felt by the proxy
std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const SceneIndex& index, const Tool& tool,
                                             Materials materials = nullptr, Lookahead* lookahead = nullptr);

/// A model that is given its contacts, whatever query finds them. \throws Error for the proxy, which asks for
/// contacts by itself.
std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const Tool& tool);

/// What a device of DeviceConfig is connected with.
struct DeviceConnections {
  HandPath hand;                      ///< of kSimulated, in the device's frame
  Trajectory playback;                ///< of kPlayback, in the device's frame
  ClientHand* client_hand = nullptr;  ///< of kClient; must outlive the device
};

/// The device of `config`, not open yet. \param loop_rate LoopConfig::rate, at which what is simulated is
/// read. Unit: [Hz]. \pre the connection of its kind is there \throws Error for a profile that there is not.
std::unique_ptr<HapticDevice> make_device(const DeviceConfig& config, double loop_rate,
                                          DeviceConnections connections);

}  // namespace palpate
