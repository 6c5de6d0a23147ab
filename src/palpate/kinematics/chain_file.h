/// \file
/// Serial chains from TOML and URDF files.
#pragma once

#include <string>
#include <string_view>

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// Reads a chain from URDF (a file that begins with '<') or TOML:
///
///     name = "arm"
///     base = "room"                    # a link; may be left out where only one is no joint's child
///     tip = "handle"                   # likewise, where only one is no joint's parent
///
///     [[link]]                         # inertia may be left out: a link without mass
///     name = "handle"
///     mass = 0.5                       # kg
///     center = [0.0, 0.0, 0.05]        # of mass, in the link's frame, m
///     inertia = [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]   # about it: xx, yy, zz, xy, xz, yz, kg m^2
///
///     [[joint]]
///     name = "wrist"
///     type = "revolute"                # prismatic, revolute or fixed
///     parent = "forearm"               # links
///     child = "handle"
///     axis = [0.0, 0.0, 1.0]
///     position = [0.0, 0.0, 0.4]       # of the joint in the parent's frame, m; default 0, 0, 0
///     orientation = [1.0, 0.0, 0.0, 0.0]            # qw, qx, qy, qz; default the parent's
///     lower = -1.5                     # m or rad, as upper and rest
///     upper = 1.5
///     rest = 0.0                       # where redundancy takes it; default the middle
///     velocity = 3.0                   # m/s or rad/s
///     acceleration = 20.0              # m/s^2 or rad/s^2
///     effort = 40.0                    # N or N m; may be left out: as much as is needed
///
/// Fixed joints are joined with the link before them. Links beside the way from base to tip are refused: what
/// hangs there would be moved, too.
///
/// URDF has no limits of acceleration: a joint is taken to reach its velocity in kUrdfRampTime. A continuous
/// joint turns by two turns at most, each way.
///
/// What was read is compared with the forward kinematics of KDL at several postures.
/// \throws Error, one line with file and joint, for a file that cannot be read or describes no such chain:
/// loops, missing links, branches, negative inertias or masses, limits that are none.
SerialChain read_chain(const std::string& path);
/// The same of a file's text. \param name that messages call it
SerialChain parse_chain(const std::string& name, std::string_view text);

inline constexpr double kUrdfRampTime = 0.25;  ///< Unit: [s].

/// A room-scale device of HapticGiant's class: a gantry of 4.7 m x 5.5 m under the ceiling, and an arm of six
/// joints that hangs from it. The room is HapticGiant's; all other dimensions, masses and limits are assumed,
/// and stand in giant_chain_text(). The base's frame is in the middle of the floor, z up.
SerialChain giant_chain();
/// It as a TOML file, to begin another from.
std::string_view giant_chain_text();

}  // namespace palpate
