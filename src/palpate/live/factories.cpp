#include <palpate/live/factories.h>

#include <utility>

#include <palpate/base/error.h>
#include <palpate/device/playback_device.h>
#include <palpate/device/profiles.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/material_file.h>

namespace palpate {

Materials load_materials(const ForceConfig& config, const std::string& scene, const Progress& progress) {
  return std::make_shared<MaterialMap>(
      config.materials.empty() ? std::vector<MaterialRegion>{} : read_materials(config.materials),
      scene.empty() ? PlyMaterials{} : read_ply_materials(scene, progress));
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
  throw Error(
      "--model proxy asks for contacts by itself, as --pipeline exact finds them; take that, or --model "
      "density");
}

std::unique_ptr<HapticDevice> make_device(const DeviceConfig& config, double loop_rate,
                                          DeviceConnections connections) {
  DeviceProfile profile = device_profile(config.profile);
  DeviceCapabilities& capabilities = profile.capabilities;
  if (config.kind == DeviceKind::kClient) {
    capabilities.rate = config.client_rate;
    // Of what a client holds, nobody knows.
    capabilities.damping = capabilities.watchdog = 0.0;
    capabilities.damping_source = DampingSource::kUnknown;
    return std::make_unique<ClientDevice>(capabilities, *connections.client_hand);
  }
  capabilities.rate = loop_rate;  // what is simulated answers whenever it is asked
  if (config.kind == DeviceKind::kPlayback)
    return std::make_unique<PlaybackDevice>(capabilities, std::move(connections.playback));
  return std::make_unique<SimulatedDevice>(capabilities, profile.plant, config.hand,
                                           std::move(connections.hand));
}

}  // namespace palpate
