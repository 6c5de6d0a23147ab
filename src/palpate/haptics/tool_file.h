/// \file
/// Tool files: tools of several ellipsoids in TOML.
#pragma once

#include <string>
#include <string_view>

#include <palpate/haptics/tool.h>

namespace palpate {

/// Limits of a tool. The limits of lengths keep every product in contact computations within the range of a
/// double.
inline constexpr std::size_t kMaxToolParts = 256;
inline constexpr double kMinToolAxis = 1e-6, kMaxToolAxis = 1e6;  ///< Unit: [m].

/// Reads a tool file:
///
///     [[ellipsoid]]                    # one to kMaxToolParts
///     name = "thumb tip"
///     semi_axes = [0.008, 0.009, 0.014]       # m
///     position = [0.03, 0.02, 0.0]            # of its centre in the tool frame, m; default 0, 0, 0
///     orientation = [1.0, 0.0, 0.0, 0.0]      # qw, qx, qy, qz of its axes; default the tool frame's
///
/// The origin of the tool frame is the handle: the point whose pose the device reports, and about which
/// torque is taken. \throws Error, which names line and key, if the file cannot be read or is not a valid
/// tool.
Tool read_tool(const std::string& path);
/// Parses the text of a tool file. \param name used in messages
Tool parse_tool(const std::string& name, std::string_view text);

/// Returns the text of a tool file for `tool`; orientations to twelve digits. Contains no apostrophes, so
/// that it fits in TOML's literal strings.
std::string tool_text(const Tool& tool);

}  // namespace palpate
