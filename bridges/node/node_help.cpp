#include "node_help.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace palpate::node {

bool print_help(const NodeCommand& command, int argc, const char* const* argv) {
  const auto asks = [](std::string_view argument) { return argument == "--help" || argument == "-h"; };
  if (std::none_of(argv + 1, argv + argc, asks)) return false;
  std::printf(
      "%s\n"
      "Usage: %s\n"
      "\n"
      "Parameters:\n"
      "  scene, config           files, as for palpate run; the default is the built-in scene\n"
      "  device                  topic prefix of the driver, with options: /omni,force_max=3.3\n"
      "  device_frame            tf frame of the device's base\n"
      "  world_frame, tf_prefix  name of the world frame, and prefix of the other tf frames\n"
      "  hands                   other hands in the scene: NAME or NAME=FILE.toml, separated by commas;\n"
      "                          their parameters are left%sdevice, left%sstiffness, ...\n"
      "  hands_touch             true: the hands feel each other's tools\n"
      "  scenes                  folders of scenes that can be opened, separated by commas\n"
      "  recordings              folder for recordings\n"
      "  cloud_decimation        n: publish every n-th centre of the Gaussians\n"
      "and any setting of scene, tool, force, loop and workspace of palpate run, with _ for -: stiffness,\n"
      "workspace_offset, ...\n"
      "\n"
      "SIGINT and SIGTERM end the node after the force has fallen to zero; SIGUSR1 is an emergency stop.\n",
      command.summary, command.usage, command.separator, command.separator);
  return true;
}

}  // namespace palpate::node
