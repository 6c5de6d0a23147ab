#include <palpate/device/profiles.h>

#include <algorithm>
#include <array>

#include <palpate/base/error.h>

namespace palpate {
namespace {

/// Watchdog of a simulated device: as long as ServoLoop waits for a stalled loop. Unit: [s].
constexpr double kWatchdog = 0.05;

/// Other properties follow from the class of device. force_sustained: the maker of the Touch gives a peak and
/// a 24-hour force, Force Dimension a continuous force; for the Falcon it is unknown. damping: assumed, of
/// the usual magnitude for such devices (0.1 to 5 N s/m), and not derived from stiffness_max.
struct Figures {
  const char* name;
  double force_max, force_sustained, torque_max, stiffness_max, damping_max, workspace, mass, damping,
      coulomb, resolution;
};

constexpr std::array<Figures, 5> kFigures{{
    {"touch", 3.3, 0.88, 0.0, 700.0, 5.0, 0.035, 0.045, 0.2, 0.26, 55e-6},
    {"omega", 12.0, 12.0, 0.0, 5000.0, 30.0, 0.055, 0.15, 1.0, 0.05, 10e-6},
    {"lambda.7", 12.0, 12.0, 0.3, 8000.0, 30.0, 0.085, 0.25, 1.0, 0.05, 10e-6},
    {"delta.3", 20.0, 20.0, 0.0, 5000.0, 30.0, 0.13, 0.25, 1.0, 0.1, 20e-6},
    {"falcon", 8.0, 0.0, 0.0, 3000.0, 20.0, 0.05, 0.2, 2.0, 0.3, 50e-6},
}};

DeviceProfile profile(const Figures& f) {
  DeviceProfile p;
  p.capabilities.name = f.name;
  p.capabilities.force_max = f.force_max;
  p.capabilities.force_sustained = f.force_sustained;
  p.capabilities.torque_max = p.capabilities.torque_sustained = f.torque_max;
  p.capabilities.actuated.rotation = f.torque_max > 0.0 ? 3 : 0;
  p.capabilities.watchdog = kWatchdog;
  p.capabilities.stiffness_max = f.stiffness_max;
  p.capabilities.damping_max = f.damping_max;
  p.capabilities.damping_source = DampingSource::kSimulated;
  p.capabilities.workspace = f.workspace;
  p.plant.mass = f.mass;
  p.plant.damping = p.capabilities.damping = f.damping;
  if (f.torque_max > 0.0) p.capabilities.angular_damping = p.plant.gyration * p.plant.gyration * f.damping;
  p.plant.coulomb = f.coulomb;
  p.plant.resolution = f.resolution;
  p.plant.turn_resolution = f.resolution / p.plant.gyration;
  return p;
}

}  // namespace

std::span<const DeviceProfile> device_profiles() {
  static const std::array<DeviceProfile, kFigures.size()> profiles = [] {
    std::array<DeviceProfile, kFigures.size()> all;
    std::transform(kFigures.begin(), kFigures.end(), all.begin(), profile);
    return all;
  }();
  return profiles;
}

std::vector<std::string> profile_names() {
  std::vector<std::string> names;
  for (const DeviceProfile& p : device_profiles()) names.push_back(p.capabilities.name);
  return names;
}

const DeviceProfile& device_profile(std::string_view name) {
  std::string names;
  for (const DeviceProfile& p : device_profiles()) {
    if (p.capabilities.name == name) return p;
    names += (names.empty() ? "" : ", ") + p.capabilities.name;
  }
  throw Error("there is no device profile '{}'; use one of {}", name, names);
}

}  // namespace palpate
