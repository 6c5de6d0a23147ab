/// \file
/// Text options of a CRTK device, following `--device ros1:` or `ros2:`.
#pragma once

#include <string>

#include <palpate/gateway/crtk_device.h>

namespace palpate {

/// Topic prefix and options of a CRTK device.
struct CrtkArguments {
  std::string prefix;  ///< of its topics: "/omni" for /omni/measured_cp
  CrtkOptions options;
};

/// Parses text such as "/omni,force_max=3.3,rate=500": a prefix, then any of
///
///     force_max         N, at most 1000 (3.3, the weakest commercial device)
///     force_sustained   N (equal to force_max)
///     torque_max        N m (0: no motors for the orientation)
///     stiffness_max     N/m (0: unknown)
///     damping           N s/m (0: unknown)
///     angular_damping   N m s/rad (0: unknown)
///     damping_max       N s/m, that models may render (0: none)
///     workspace         m
///     rate              Hz, minimum rate of its poses, at least 20 (1000)
///     frame             frame_id of its poses (that of a publisher's first pose)
///     delay             s, from the arrival of a wrench until the motors apply it (0)
///     one_way           s, latency of the network, if echoes are not answered (0.0005)
///     extrapolation     s, at most 0.01 (0: none)
///
/// Defaults are in parentheses.
///
/// \param kind transport, such as "ros1", for error messages \throws Error that names the invalid option.
CrtkArguments parse_crtk_arguments(const std::string& kind, const std::string& text);

}  // namespace palpate
