#include "other_publisher.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcException.h>

namespace palpate::ros1 {
namespace {

using XmlRpc::XmlRpcValue;

/// Longest wait for a node to accept a connection. Unit: [ms].
constexpr int kAccepts = 200;

/// Returns whether a connection to `address` is refused; a host that does not answer refuses nothing.
bool refuses(const addrinfo& address) {
  const int socket = ::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  int error = ::connect(socket, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    pollfd waits{socket, POLLOUT, 0};
    socklen_t size = sizeof error;
    if (::poll(&waits, 1, kAccepts) != 1 || ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) != 0)
      error = 0;
  }
  ::close(socket);
  return error == ECONNREFUSED;
}

/// Returns whether the process of node `name` has certainly ended.
bool has_ended(const std::string& name) {
  XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = name;
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return false;
  std::string host;
  std::uint32_t port = 0;
  if (uri.getType() != XmlRpcValue::TypeString ||
      !ros::network::splitURI(static_cast<std::string>(uri), host, port))
    return false;
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, ::freeaddrinfo);
  return refuses(*all);
}

/// \param publishers of all topics: [[topic, [node, ...]], ...]
std::string find(XmlRpcValue publishers, const std::vector<std::string>& topics) {
  for (int k = 0; k < publishers.size(); ++k) {
    if (std::count(topics.begin(), topics.end(), static_cast<std::string>(publishers[k][0])) == 0) continue;
    XmlRpcValue& nodes = publishers[k][1];
    for (int n = 0; n < nodes.size(); ++n) {
      std::string name = nodes[n];
      if (name != ros::this_node::getName() && !has_ended(name)) return name;
    }
  }
  return {};
}

}  // namespace

std::optional<std::string> other_publisher(const std::vector<std::string>& topics) {
  XmlRpcValue request, response, state;  // [publishers, subscribers, services]
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return std::nullopt;
  try {
    return find(state[0], topics);
  } catch (const XmlRpc::XmlRpcException&) {
    return std::nullopt;
  }
}

}  // namespace palpate::ros1
