/// \file
/// Groups of neighbouring parts of a tool.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <palpate/haptics/tool.h>

namespace palpate {

/// Parts of a tool that are near each other, and a solid that contains them.
struct PartGroup {
  ToolPart around;  ///< in the tool frame, along its axes; or the part itself where it is alone
  std::vector<std::size_t> members;  ///< by number, not empty
};

/// A tool of no more parts has no groups of several.
inline constexpr std::size_t kFewParts = 8;

/// Members of a group at most: all of its Gaussians are compared with each.
inline constexpr std::size_t kMostInGroup = 8;

/// The largest cross-section of a part, over pi. Unit: [m^2].
double section(const ToolPart& part);

/// Divides `parts` so that one search of the scene serves a group. Gaussians lie on surfaces, so that a
/// search costs as the cross-section of what it is for: that of a group's solid, the largest there is, is
/// smaller than those of its parts together. Each part is in one group.
std::vector<PartGroup> group_parts(std::span<const ToolPart> parts);

}  // namespace palpate
