/// \file
/// Devices that are sold, as figures.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// What a device can do, and its mechanics for a simulation.
struct DeviceProfile {
  DeviceCapabilities capabilities;
  PlantProperties plant;
};

/// Touch, omega, lambda.7, delta.3 and Falcon: forces and workspaces from the makers' data sheets; of the
/// mechanics, what those leave out is assumed, of the usual size for the class. The damping that is credited
/// is that of the plant (DampingSource::kSimulated); of a device of hardware nothing is credited that was not
/// measured.
std::span<const DeviceProfile> device_profiles();

/// Of each, DeviceCapabilities::name.
std::vector<std::string> profile_names();

/// The profile of that name. \throws Error, which names those there are.
const DeviceProfile& device_profile(std::string_view name);

}  // namespace palpate
