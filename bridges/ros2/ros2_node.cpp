// The node palpate_ros2.
#include <cstdio>
#include <exception>

#include <node_help.h>
#include <node_notices.h>
#include <node_settings.h>
#include <run_node.h>

#include "ros2_sink.h"
#include "ros2_transport.h"
#include "ros_arguments.h"

namespace palpate {
namespace {

constexpr const char* kProgram = "palpate_ros2";
constexpr node::NodeCommand kCommand{
    "ROS 2 node that renders a Gaussian Splatting scene on a CRTK haptic device",
    "palpate_ros2 [--ros-args [-p PARAMETER:=VALUE]... [-r FROM:=TO]... [--enclave NAME]]", "."};

void run(int argc, char** argv) {
  const ros2::NodeArguments arguments = ros2::read_arguments(argc, argv);
  const node::NodeSettings settings = node::read_node_settings("ros2", arguments.parameters);
  node::NodeNotices notices(kProgram);
  const ros2::Resolve resolve = [&arguments](const std::string& name) {
    return arguments.names.resolve(name);
  };
  ros2::Participant participant([&notices](const std::string& line) { notices.say(line); },
                                arguments.enclave);
  node::NodeNetwork network;
  network.transport = [&](const std::string& prefix, node::NodeNotices& of_hand) {
    return ros2::make_transport(
        prefix, [&of_hand](const std::string& line) { of_hand.say(line); }, resolve, &participant);
  };
  network.sink = [&](const node::NodeSettings&, const std::vector<node::SinkHand>& hands) {
    return ros2::make_sink(participant, resolve, settings.world_frame, hands);
  };
  network.is_up = [] { return true; };
  node::run_node(settings, network, notices);
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (palpate::node::print_help(palpate::kCommand, argc, argv)) return 0;
  try {
    palpate::run(argc, argv);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", palpate::kProgram, error.what());
    return 1;
  }
}
