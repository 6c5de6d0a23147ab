/// \file
/// Tools of the trials, from the width of a hand to the point of a pin.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/haptics/tool.h>

namespace palpate {

/// Returns the names that trial_tool() accepts. Semi-axes in mm:
///   ball20, ball10, ball5, ball2   round
///   rod      100 x 3 x 3
///   needle   5 x 5 x 100, which trials push tip first
///   disc     30 x 30 x 5
///   plate    100 x 100 x 10
std::span<const std::string_view> trial_tools();

/// Returns the tool of that name; nothing if it is not among trial_tools().
std::optional<Tool> trial_tool(std::string_view name);

/// The tool, turned about its handle.
Tool turned(const Tool& tool, const Eigen::Quaterniond& turn);

/// Points on the surface of the tool at the origin that face along the unit vector `along`: for each part
/// about its surface over `spacing`^2, 100 to 6000. Unit: [m].
std::vector<Eigen::Vector3d> front_of(const Tool& tool, const Eigen::Vector3d& along, double spacing);

}  // namespace palpate
