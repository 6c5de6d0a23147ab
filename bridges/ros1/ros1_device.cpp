// Device plug-in of `palpate run --device ros1:/omni`: a device with a CRTK driver on ROS 1.
#include <palpate/base/nonblocking_stderr.h>
#include <palpate/device/export_device.h>
#include <palpate/gateway/crtk_device.h>
#include <palpate/gateway/crtk_options.h>

#include "ros1_transport.h"

namespace palpate {
namespace {

void say(const std::string& line) { write_to_stderr("palpate: note: " + line + "\n"); }

std::unique_ptr<HapticDevice> make(const std::string& text) {
  CrtkArguments arguments = parse_crtk_arguments("ros1", text);
  return std::make_unique<CrtkDevice>(std::move(arguments.options),
                                      make_ros1_transport(std::move(arguments.prefix), say));
}

}  // namespace
}  // namespace palpate

__attribute__((visibility("default"))) const PalpateDevicePlugin* palpate_device_plugin(std::uint32_t) {
  return &palpate::ExportedDevice<palpate::make>::kPlugin;
}
