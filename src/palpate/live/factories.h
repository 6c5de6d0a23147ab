/// \file
/// Factories of the parts of a live system from its configuration.
#pragma once

#include <memory>
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
  HandPath hand;                      ///< of kSimulated and a giant, in the device's frame
  Trajectory playback;                ///< of kPlayback, in the device's frame
  ClientHand* client_hand = nullptr;  ///< of kClient; must outlive the device
  double contact_stiffness = 0.0;     ///< of a giant: what it is to be stable with. Unit: [N/m].
};

/// The device of `config`, not open yet. \param loop_rate LoopConfig::rate, at which what is simulated is
/// read. Unit: [Hz]. \pre the connection of its kind is there \throws Error for a profile that there is not;
/// for a chain that cannot be read; for an admittance that is not stable with `contact_stiffness`, with the
/// bound that it breaks; for MuJoCo where the library was built without it.
std::unique_ptr<HapticDevice> make_device(const DeviceConfig& config, double loop_rate,
                                          DeviceConnections connections);

/// A giant as `config` has it. \param loop_rate LoopConfig::rate. Unit: [Hz]. \param contact_stiffness Unit:
/// [N/m]. \throws Error for a chain that cannot be read.
GiantSetup giant_setup(const DeviceConfig& config, double loop_rate, double contact_stiffness);

/// Its mechanics, with a hand on that path in the base's frame. \param kind a giant's \throws Error for
/// MuJoCo where the library was built without it.
std::unique_ptr<JointPlant> make_giant_plant(DeviceKind kind, const GiantSetup& setup, HandPath hand);

}  // namespace palpate
