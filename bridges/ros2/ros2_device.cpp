// Device plug-in of `palpate run --device ros2:/omni`: a device with a CRTK driver on ROS 2.
#include <palpate/base/nonblocking_stderr.h>
#include <palpate/device/export_device.h>
#include <palpate/gateway/crtk_device.h>
#include <palpate/gateway/crtk_options.h>

#include "ros2_transport.h"

namespace palpate {
namespace {

void say(const std::string& line) { write_to_stderr("palpate: note: " + line + "\n"); }

std::unique_ptr<HapticDevice> make(const std::string& text) {
  CrtkArguments arguments = parse_crtk_arguments("ros2", text);
  const auto same = [](const std::string& name) { return name; };
  return std::make_unique<CrtkDevice>(std::move(arguments.options),
                                      ros2::make_transport(std::move(arguments.prefix), say, same));
}

}  // namespace
}  // namespace palpate

__attribute__((visibility("default"))) const PalpateDevicePlugin* palpate_device_plugin(std::uint32_t) {
  return &palpate::ExportedDevice<palpate::make>::kPlugin;
}
