#include <palpate/rosbridge/own_address.h>

#include <array>
#include <cstdint>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

/// Nobody's address (RFC 5737), to which only the default route leads.
constexpr const char* kElsewhere = "192.0.2.1";

std::string ipv4_text(const in_addr& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  return ::inet_ntop(AF_INET, &address, text.data(), text.size());
}

bool is_usable(const in_addr& address) {
  constexpr std::uint32_t kLoopbackNetwork = 127;
  const std::uint32_t bits = ntohl(address.s_addr);
  return bits != INADDR_ANY && bits >> 24U != kLoopbackNetwork;
}

/// Connecting a datagram socket chooses the interface and sends nothing.
std::string default_route_address() {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return {};
  sockaddr_in peer{}, own{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(9);  // discard
  ::inet_pton(AF_INET, kElsewhere, &peer.sin_addr);
  socklen_t length = sizeof own;
  const bool found = ::connect(descriptor, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0 &&
                     ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &length) == 0;
  ::close(descriptor);
  return found && is_usable(own.sin_addr) ? ipv4_text(own.sin_addr) : std::string();
}

std::string first_interface_address() {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return {};
  std::string found;
  for (const ifaddrs* one = all; one != nullptr && found.empty(); one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET || (one->ifa_flags & IFF_UP) == 0)
      continue;
    const in_addr address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr;
    if (is_usable(address)) found = ipv4_text(address);
  }
  ::freeifaddrs(all);
  return found;
}

}  // namespace

bool is_any_address(std::string_view address) { return address == "0.0.0.0" || address == "::"; }

std::string own_address() {
  const std::string routed = default_route_address();
  return routed.empty() ? first_interface_address() : routed;
}

}  // namespace palpate
