/// \file
/// Tools of many ellipsoids, in TOML.
#pragma once

#include <string>
#include <string_view>

#include <palpate/haptics/tool.h>

namespace palpate {

/// Limits of a tool. Those of lengths keep every product of the contact mathematics inside a double.
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
/// The origin of the tool frame is the handle: what the device reports, and about which torque is felt.
/// \throws Error for a file that cannot be read or is no such tool, naming line and key.
Tool read_tool(const std::string& path);
/// The same of a file's text. \param name that messages call it
Tool parse_tool(const std::string& name, std::string_view text);

/// The text of a tool file that is read as `tool`; orientations to twelve digits. Has no apostrophes, so that
/// it can stand in TOML's literal strings.
std::string tool_text(const Tool& tool);

}  // namespace palpate
