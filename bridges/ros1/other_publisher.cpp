#include "other_publisher.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <utility>

#include <ros/network.h>
#include <ros/this_node.h>

namespace palpate::ros1 {
namespace {

/// Longest wait for a node to accept a connection. Unit: [ms].
constexpr int kAccepts = 200;

/// Result of an attempt to connect.
enum class Attempt {
  kRefused,  ///< nobody listens
  kNoRoute,  ///< this host has no such network, so that it says nothing about the other
  kOpen      ///< accepted, or unanswered
};

Attempt connect_to(const addrinfo& address) {
  const int socket = ::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return errno == EAFNOSUPPORT ? Attempt::kNoRoute : Attempt::kOpen;
  int error = ::connect(socket, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    pollfd waits{socket, POLLOUT, 0};
    socklen_t size = sizeof error;
    if (::poll(&waits, 1, kAccepts) != 1 || ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) != 0)
      error = 0;
  }
  ::close(socket);
  if (error == ECONNREFUSED) return Attempt::kRefused;
  return error == EADDRNOTAVAIL || error == ENETUNREACH ? Attempt::kNoRoute : Attempt::kOpen;
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

/// Returns the addresses of a host; null if it is unknown.
Addresses addresses_of(const std::string& host, std::uint32_t port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) found = nullptr;
  return {found, ::freeaddrinfo};
}

bool is_loopback(const addrinfo& address) {
  if (address.ai_family == AF_INET) {
    constexpr std::uint32_t kLoopback = 127;  // 127.0.0.0/8
    const auto* of = reinterpret_cast<const sockaddr_in*>(address.ai_addr);
    return ntohl(of->sin_addr.s_addr) >> 24 == kLoopback;
  }
  return address.ai_family == AF_INET6 &&
         IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6*>(address.ai_addr)->sin6_addr);
}

/// Returns whether a node of `host`, which has a loopback address here, is on this host: by the name of this
/// node's, or where this node itself is reached at such an address alone.
bool is_here(const std::string& host) {
  const std::string& own = ros::network::getHost();
  return host == own || own == "localhost" || own == "::1" || own.rfind("127.", 0) == 0;
}

/// Returns whether the process of the node with this URI has certainly ended: its host refuses, at all of its
/// addresses. Nodes listen at those of IPv4 only, which need not come first. A loopback address says nothing
/// of a node that may be on another host, which has called itself `localhost`.
bool has_ended(const std::string& uri) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return false;
  const Addresses all = addresses_of(host, port);
  bool refused = false;
  for (const addrinfo* address = all.get(); address != nullptr; address = address->ai_next) {
    const Attempt attempt = connect_to(*address);
    if (attempt == Attempt::kOpen) return false;
    if (attempt == Attempt::kRefused && is_loopback(*address) && !is_here(host)) return false;
    refused = refused || attempt == Attempt::kRefused;
  }
  return refused;
}

}  // namespace

void OtherPublisher::update(const MasterState& state, bool restarted) {
  look_at_list(state, restarted);
  tell();  // before what follows, which may take long
  for (auto& [name, node] : known_) {
    if (node.listed) {
      const std::string uri = uri_of(name);
      const bool another = !uri.empty() && std::exchange(node.uri, uri) != uri;
      if (another && std::exchange(node.ended, false)) tell();
    }
    node.ended = !node.uri.empty() && has_ended(node.uri);
  }
  tell();
}

void OtherPublisher::look_at_list(const MasterState& state, bool restarted) {
  const std::string& self = ros::this_node::getName();
  // Otherwise, others need not be registered either.
  const bool has_this = std::all_of(topics_.begin(), topics_.end(), [&](const std::string& topic) {
    return has(state.publishers, topic, self);
  });
  std::map<std::string, Node> now;
  for (auto& [name, node] : known_) {
    const bool unknown_to_master = restarted || !has_this || !node.listed;
    node.listed = false;
    if (unknown_to_master && !node.ended && !node.uri.empty()) now.insert({name, node});
  }
  for (const std::string& topic : topics_) {
    const auto found = state.publishers.find(topic);
    if (found == state.publishers.end()) continue;
    for (const std::string& name : found->second) {
      if (name == self) continue;
      const auto before = known_.find(name);
      Node& node = now[name];
      if (before != known_.end()) node = before->second;
      node.listed = true;
    }
  }
  known_ = std::move(now);
}

void OtherPublisher::tell() const {
  const auto one =
      std::find_if(known_.begin(), known_.end(), [](const auto& of) { return !of.second.ended; });
  tell_(one == known_.end() ? std::string() : one->first);
}

}  // namespace palpate::ros1
