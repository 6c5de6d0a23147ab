/// \file
/// Cross-check of forward kinematics against KDL.
#pragma once

#include <string>

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// \throws Error, prefixed with `where`, if KDL places the TCP elsewhere: a chain that the two interpret
/// differently must not move anything.
void compare_with_kdl(const SerialChain& chain, const std::string& where);

}  // namespace palpate
