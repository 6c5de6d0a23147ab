/// \file
/// Profiles of commercial haptic devices.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Capabilities of a device, and its mechanics for a simulation.
struct DeviceProfile {
  DeviceCapabilities capabilities;
  PlantProperties plant;
};

/// Touch, omega, lambda.7, delta.3 and Falcon: forces and workspaces from the manufacturers' data sheets;
/// mechanical figures missing there are assumed, at values typical of the class. The credited damping is that
/// of the plant (DampingSource::kSimulated); for real hardware only measured damping is credited.
std::span<const DeviceProfile> device_profiles();

/// DeviceCapabilities::name of each profile.
std::vector<std::string> profile_names();

/// Returns the profile of that name. \throws Error, which lists the available names.
const DeviceProfile& device_profile(std::string_view name);

}  // namespace palpate
