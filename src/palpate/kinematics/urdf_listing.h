/// \file
/// Links and joints of a URDF file.
#pragma once

#include <string>
#include <string_view>

#include <palpate/kinematics/chain_assembly.h>

namespace palpate {

/// \param name of the file in messages \throws Error for invalid URDF, with urdfdom's reason.
ChainListing urdf_listing(const std::string& name, std::string_view text);

}  // namespace palpate
