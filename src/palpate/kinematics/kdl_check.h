/// \file
/// Forward kinematics compared with those of KDL.
#pragma once

#include <string>

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// \throws Error, which begins with `where`, if KDL has the TCP elsewhere: a chain that the two understand
/// differently must not move anything.
void compare_with_kdl(const SerialChain& chain, const std::string& where);

}  // namespace palpate
