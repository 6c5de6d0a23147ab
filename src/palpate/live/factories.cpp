#include <palpate/live/factories.h>

#include <utility>

#include <palpate/base/error.h>
#ifdef PALPATE_HAS_MUJOCO
#include <palpate/device/giant_mujoco.h>
#endif
#include <palpate/device/giant_plant.h>
#include <palpate/device/playback_device.h>
#include <palpate/device/profiles.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/material_file.h>
#include <palpate/kinematics/chain_file.h>
#include <palpate/live/live_scene.h>

namespace palpate {
GiantSetup giant_setup(const DeviceConfig& config, double loop_rate, double contact_stiffness) {
  GiantSetup setup;
  setup.chain = driven_chain(config.chain.empty() ? giant_chain() : read_chain(config.chain), config.hand);
  setup.hand = config.hand;
  setup.virtual_mass = config.virtual_mass;
  setup.virtual_damping = config.virtual_damping;
  setup.contact_stiffness = contact_stiffness;
  setup.period = 1.0 / loop_rate;
  return setup;
}

std::unique_ptr<JointPlant> make_giant_plant(DeviceKind kind, const GiantSetup& setup, HandPath hand) {
  const JointPlantProperties drives = GiantProperties().drives;
  const GripProperties grip{.hand = setup.hand, .gyration = 0.05};
  if (kind == DeviceKind::kGiant)
    return std::make_unique<GiantPlant>(setup.chain, drives, grip, std::move(hand));
#ifdef PALPATE_HAS_MUJOCO
  return std::make_unique<GiantMujoco>(setup.chain, drives, grip, std::move(hand));
#else
  throw Error("giant-mujoco: this program was built without MuJoCo (libmujoco-dev); use giant");
#endif
}

Materials load_materials(const ForceConfig& config, const std::string& scene, const Progress& progress) {
  return std::make_shared<MaterialMap>(
      config.materials.empty() ? std::vector<MaterialRegion>{} : read_materials(config.materials),
      scene.empty() ? material_columns(built_in_scene()) : read_ply_materials(scene, progress));
}

std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const SceneIndex& index, const Tool& tool, Materials materials,
                                             Lookahead* lookahead) {
  if (kind != ForceModelKind::kProxy) return make_force_model(kind, config, tool);
  ProxyParameters parameters = config.proxy;
  parameters.materials = std::move(materials);
  return std::make_unique<ProxyForce>(index, tool, parameters, lookahead);
}

std::unique_ptr<ForceModel> make_force_model(ForceModelKind kind, const ForceConfig& config,
                                             const Tool& tool) {
  switch (kind) {
    case ForceModelKind::kDensity: return std::make_unique<DensityForce>(tool, config.density);
    case ForceModelKind::kField:
      return std::make_unique<FieldForce>(tool, FieldParameters{config.proxy.stiffness});
    default: break;
  }
  throw Error("--model proxy requires --pipeline exact; use that, or --model density");
}

std::unique_ptr<HapticDevice> make_device(const DeviceConfig& config, double loop_rate,
                                          DeviceConnections connections) {
  if (is_giant(config.kind)) {
    const GiantSetup& setup = *connections.giant;
    return make_giant_loop(setup, make_giant_plant(config.kind, setup, std::move(connections.hand)));
  }
  DeviceProfile profile = device_profile(config.profile);
  DeviceCapabilities& capabilities = profile.capabilities;
  if (config.kind == DeviceKind::kClient) {
    capabilities.rate = config.client_rate;
    // The mechanics of a client's device are unknown.
    capabilities.damping = capabilities.angular_damping = capabilities.watchdog = 0.0;
    capabilities.damping_source = DampingSource::kUnknown;
    return std::make_unique<ClientDevice>(capabilities, *connections.client_hand);
  }
  capabilities.rate = loop_rate;  // a simulated device returns a new reading whenever it is read
  if (config.kind == DeviceKind::kPlayback)
    return std::make_unique<PlaybackDevice>(capabilities, std::move(connections.playback));
  return std::make_unique<SimulatedDevice>(capabilities, profile.plant, config.hand,
                                           std::move(connections.hand));
}

}  // namespace palpate
