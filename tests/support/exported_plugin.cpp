// A driver in C++, exported as a plug-in: a ScriptedDevice, which needs calibration and is silent for a
// while.
#include <cmath>
#include <optional>
#include <stdexcept>

#include <palpate/device/export_device.h>
#include <palpate/device/testing/scripted_device.h>

namespace {

palpate::Pose swing(double t) {
  palpate::Pose pose;
  pose.position.x() = 0.01 * std::sin(5.0 * t);
  return pose;
}

/// Of the admittance type, as it knows once it is open only.
class AdmittanceDevice final : public palpate::HapticDevice {
 public:
  void open() override {
    can_.emplace().kind = palpate::Causality::kAdmittance;
    HapticDevice::open();
  }
  const palpate::DeviceCapabilities& capabilities() const override { return can_.value(); }
  bool read(double, palpate::DeviceReading&) override { return false; }
  void write(const palpate::Wrench&) override {}
  void stop() noexcept override {}

 private:
  std::optional<palpate::DeviceCapabilities> can_;
};

std::unique_ptr<palpate::HapticDevice> make(const std::string& arguments) {
  using palpate::test::DeviceFault;
  if (arguments == "null") return nullptr;
  if (arguments == "admittance") return std::make_unique<AdmittanceDevice>();
  if (!arguments.empty() && arguments != "nan")
    throw std::runtime_error("takes no arguments but nan and admittance, not '" + arguments + "'");
  palpate::DeviceCapabilities can;
  can.name = "scripted";
  can.force_max = 10.0;
  can.sensed.rotation = 0;
  can.damping = 0.25;
  can.angular_damping = 0.5e-3;
  can.damping_source = palpate::DampingSource::kMeasured;
  const DeviceFault fault = arguments.empty() ? DeviceFault::kSilent : DeviceFault::kNan;
  return std::make_unique<palpate::test::ScriptedDevice>(
      can, swing, std::vector<palpate::test::ScriptedFault>{{0.05, 0.07, fault}});
}

}  // namespace

const PalpateDevicePlugin* palpate_device_plugin(uint32_t) { return &palpate::ExportedDevice<make>::kPlugin; }
