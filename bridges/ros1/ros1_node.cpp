// The node palpate_ros1.
#include <cstdio>

#include <palpate/base/real_time.h>

#include <node_help.h>
#include <node_notices.h>
#include <node_settings.h>
#include <run_node.h>

#include "ros1_transport.h"
#include "ros_node.h"
#include "ros_sink.h"

namespace palpate {
namespace {

constexpr const char* kProgram = "palpate_ros1";
constexpr node::NodeCommand kCommand{
    "ROS 1 node that renders a Gaussian Splatting scene on a CRTK haptic device",
    "palpate_ros1 [_PARAMETER:=VALUE]... [FROM:=TO]...", "/"};

std::unique_ptr<CrtkTransport> transport(const std::string& prefix, node::NodeNotices& notices) {
  return make_ros1_transport(prefix, [&notices](const std::string& line) { notices.say(line); });
}

std::unique_ptr<node::NodeSink> sink(const node::NodeSettings& settings, std::vector<node::SinkHand> hands) {
  return ros1::make_sink(settings.world_frame, std::move(hands));
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  using namespace palpate;
  if (node::print_help(kCommand, argc, argv)) return 0;
  try {
    const node::NodeSettings settings = node::read_node_settings("ros1", ros1::init_node(argc, argv));
    call_real_time(kNetworkPriority, ros1::start_node);
    node::NodeNotices notices(kProgram);
    node::run_node(settings, {transport, sink, ros1::is_up}, notices);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", kProgram, error.what());
    return 1;
  }
}
