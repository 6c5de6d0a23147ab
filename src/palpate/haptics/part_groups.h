/// \file
/// Groups of neighbouring tool parts.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <palpate/haptics/tool.h>

namespace palpate {

/// Neighbouring parts of a tool and a solid that contains them.
struct PartGroup {
  ToolPart around;                   ///< in the tool frame, along its axes; the part itself if single
  std::vector<std::size_t> members;  ///< by number, not empty
};

/// Tools of at most this many parts have only single-part groups.
inline constexpr std::size_t kFewParts = 8;

/// Largest size of a group: each member is compared with all Gaussians of the group.
inline constexpr std::size_t kMostInGroup = 8;

/// The largest cross-section of a part, over pi. Unit: [m^2].
double section(const ToolPart& part);

/// Divides `parts` into groups that share one search of the scene. Gaussians lie on surfaces, so that the
/// cost of a search grows with the cross-section of its solid: the largest cross-section of a group's solid
/// is less than the sum of those of its parts. Each part is in one group.
std::vector<PartGroup> group_parts(std::span<const ToolPart> parts);

}  // namespace palpate
