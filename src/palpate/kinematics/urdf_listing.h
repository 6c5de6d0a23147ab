/// \file
/// Links and joints of a URDF file.
#pragma once

#include <string>
#include <string_view>

#include <palpate/kinematics/chain_assembly.h>

namespace palpate {

/// \param name that messages call it \throws Error for what is no URDF, with urdfdom's reason.
ChainListing urdf_listing(const std::string& name, std::string_view text);

}  // namespace palpate
