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
/// Fixed joints are merged with the link before them. Links that are not between base and tip are rejected:
/// they would be moved, too.
///
/// URDF has no acceleration limits: a joint is assumed to reach its maximum velocity in kUrdfRampTime. A
/// continuous joint is limited to two turns in each direction.
///
/// The chain is compared with the forward kinematics of KDL at several postures. \throws Error, one line with
/// file and joint, for a file that cannot be read or does not describe such a chain: loops, missing links,
/// branches, negative inertias or masses, invalid limits.
SerialChain read_chain(const std::string& path);
/// Parses the text of such a file. \param name of the file in messages
SerialChain parse_chain(const std::string& name, std::string_view text);

inline constexpr double kUrdfRampTime = 0.25;  ///< Unit: [s].

/// A room-scale device of HapticGiant's class: a gantry of 4.7 m x 5.5 m under the ceiling, and an arm of six
/// joints that hangs from it. The room dimensions are HapticGiant's; all other dimensions, masses and limits
/// are assumptions, listed in giant_chain_text(). The base frame is in the middle of the floor, z up.
SerialChain giant_chain();
/// giant_chain() as a TOML file, a template for others.
std::string_view giant_chain_text();

}  // namespace palpate
