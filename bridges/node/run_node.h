/// \file
/// Main function of a node: hands with CRTK devices, whose contacts and status are published as topics.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <palpate/gateway/crtk_device.h>

#include "node_notices.h"
#include "node_settings.h"
#include "node_sink.h"

namespace palpate::node {

/// Network of a node.
struct NodeNetwork {
  std::function<std::unique_ptr<CrtkTransport>(const std::string& prefix, NodeNotices& notices)> transport;
  std::function<std::unique_ptr<NodeSink>(const NodeSettings& settings, std::vector<SinkHand> hands)> sink;
  /// Returns false once the network has ended the node.
  std::function<bool()> is_up;
};

/// Runs the node until a signal or the network ends it; on return, and when it throws, the force is zero and
/// the devices are closed, except those that hang. Main thread. \param notices of the first hand \throws
/// Error if a scene, tool or device cannot be loaded, and if the driver of a device hangs when it is closed.
void run_node(const NodeSettings& settings, const NodeNetwork& network, NodeNotices& notices);

}  // namespace palpate::node
