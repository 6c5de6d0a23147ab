/// \file
/// A node: hands whose devices are drivers that speak CRTK, with what they feel as topics.
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

/// What messages go over.
struct NodeNetwork {
  std::function<std::unique_ptr<CrtkTransport>(const std::string& prefix, NodeNotices& notices)> transport;
  std::function<std::unique_ptr<NodeSink>(const NodeSettings& settings, std::vector<SinkHand> hands)> sink;
  /// False once it has been ended from outside.
  std::function<bool()> is_up;
};

/// Runs until a signal, or the network, ends it; then the force has fallen and the device is closed. The main
/// thread. \param notices of the first hand \throws Error for a scene, tool or device that cannot be had.
void run_node(const NodeSettings& settings, const NodeNetwork& network, NodeNotices& notices);

}  // namespace palpate::node
