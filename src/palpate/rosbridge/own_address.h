/// \file
/// The address of this machine for others.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Returns whether a server that listens on `address` listens on all interfaces.
bool is_any_address(std::string_view address);

/// Returns the IPv4 address of the interface of the default route, else of the first interface that is up and
/// not a loopback; empty if there is none. Sends nothing.
std::string own_address();

}  // namespace palpate
